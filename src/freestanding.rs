//! What a `no_std` static library has to bring for itself. Only in libvolgrad_core.

use core::panic::PanicInfo;

unsafe extern "C" {
    /// The host's; does not return.
    safe fn volgrad_abort() -> !;
}

/// For the compiler's sake: tests/packaging/freestanding.sh checks that no code leads here.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    volgrad_abort()
}
