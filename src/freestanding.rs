//! What a `no_std` static library has to bring for itself. Only in libvolgrad_core.

use core::panic::PanicInfo;

unsafe extern "C" {
    /// The host's, where it is needed: does not return.
    safe fn volgrad_abort() -> !;
}

/// The compiler wants it, but no code leads here, and linking drops it: tests/packaging/freestanding.sh. Where a compiler does not see that,
/// `volgrad_abort` is missing, instead of nothing being said.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    volgrad_abort()
}
