/* The header's structs and numbers are those that were last accepted (make abi), on 64-bit machines. tests/layout.rs asserts the same of
 * Rust's. */
#include <assert.h>
#include <stddef.h>
#include <stdio.h>

#include "volgrad.h"

#define SIZE(type, size) static_assert(sizeof(type) == (size), #type " changed its size")
#define OFFSET(type, field, offset) static_assert(offsetof(type, field) == (offset), #type "." #field " moved")
#define NUMBER(name, value) static_assert((name) == (value), #name " is another number")

#include "../abi/layout.h"

int main(void)
{
    puts("1 passed, 0 failed");
    return 0;
}
