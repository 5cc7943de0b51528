//! A Rust library that has nothing to do with volgrad, with the standard library and unwinding, as a program may link beside it.

use std::collections::HashMap;
use std::panic::catch_unwind;

/// Panics, catches that, and counts letters on another thread: 3 if all of this works.
#[unsafe(no_mangle)]
pub extern "C" fn other_library() -> i32 {
    std::panic::set_hook(Box::new(|_| {}));
    let caught = catch_unwind(|| Vec::<i32>::new()[1]).is_err();
    let letters = std::thread::spawn(|| {
        let mut letters = HashMap::new();
        format!("{:.3}", 2.5).chars().for_each(|letter| *letters.entry(letter).or_insert(0) += 1);
        letters.len()
    });
    i32::from(caught) * letters.join().map_or(0, |count| count as i32 - 1)
}
