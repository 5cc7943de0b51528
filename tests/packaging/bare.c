/* The machine under a program without an operating system, for examples_c/path_gradient.c: what libvolgrad_core needs (the first four
 * functions) and what that program itself calls. Of the operating system it uses two system calls, to show that it got there. */

#include <stdarg.h>
#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t count)
{
    for (size_t i = 0; i < count; i++) ((char *)to)[i] = ((const char *)from)[i];
    return to;
}

void *memmove(void *to, const void *from, size_t count)
{
    if (to < from) return memcpy(to, from, count);
    for (size_t i = count; i-- > 0;) ((char *)to)[i] = ((const char *)from)[i];
    return to;
}

void *memset(void *to, int value, size_t count)
{
    for (size_t i = 0; i < count; i++) ((char *)to)[i] = (char)value;
    return to;
}

int memcmp(const void *a, const void *b, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        int difference = ((const unsigned char *)a)[i] - ((const unsigned char *)b)[i];
        if (difference) return difference;
    }
    return 0;
}

static long system_call(long number, long a, const void *b, long c)
{
    long result;
    __asm__ volatile("syscall" : "=a"(result) : "a"(number), "D"(a), "S"(b), "d"(c) : "rcx", "r11", "memory");
    return result;
}

enum { WRITE = 1, EXIT = 60 };

void exit(int status)
{
    for (;;) system_call(EXIT, status, NULL, 0);
}

int main(void);

__attribute__((used)) static void start(void)
{
    exit(main());
}

__asm__(".globl _start\n_start:\n\txor %ebp, %ebp\n\tand $-16, %rsp\n\tcall start\n");

void *malloc(size_t bytes)
{
    static _Alignas(16) char memory[1 << 16];
    return bytes <= sizeof memory ? memory : NULL;
}

void free(void *memory)
{
    (void)memory;
}

/* To 1e-15 or so: 2^k times a series. */
double exp(double x)
{
    int k = (int)(x * 1.4426950408889634 + (x < 0 ? -0.5 : 0.5));
    double rest = x - k * 0.6931471805599453, term = 1, sum = 1;
    for (int i = 1; i < 20; i++) sum += term *= rest / i;
    for (; k > 0; k--) sum *= 2;
    for (; k < 0; k++) sum /= 2;
    return sum;
}

float expf(float x)
{
    return (float)exp(x);
}

static void put(const char *text, size_t count)
{
    system_call(WRITE, 1, text, (long)count);
}

static void put_padded(const char *end, const char *text, int width)
{
    for (int i = (int)(end - text); i < width; i++) put(" ", 1);
    put(text, (size_t)(end - text));
}

/* With `decimals`; without the zeros at its end if those are `significant` digits, of a number between 1e-4 and 1. */
static void put_number(double value, int width, int decimals, int significant)
{
    char text[64], *begin = text + 32, *end = begin;
    double size = value < 0 ? -value : value;
    for (double v = size; significant && v < 0.1; v *= 10) decimals++;
    double scale = 1;
    for (int i = 0; i < decimals; i++) scale *= 10;
    unsigned long digits = (unsigned long)(size * scale + 0.5);
    while (significant && digits % 10 == 0) digits /= 10, decimals--;
    for (int i = 0; i <= decimals || digits > 0; i++, digits /= 10) {
        if (i == decimals && decimals > 0) *--begin = '.';
        *--begin = (char)('0' + digits % 10);
    }
    if (value < 0) *--begin = '-';
    put_padded(end, begin, width);
}

static void format(const char *text, va_list values)
{
    for (; *text; text++) {
        if (*text != '%') {
            put(text, 1);
            continue;
        }
        int width = 0, decimals = 6;
        while (*++text >= '0' && *text <= '9') width = 10 * width + *text - '0';
        if (*text == '.') decimals = *++text - '0', text++;
        if (*text == 'd') put_number(va_arg(values, int), width, 0, 0);
        if (*text == 'f' || *text == 'g') put_number(va_arg(values, double), width, decimals, *text == 'g');
        if (*text == 's') {
            const char *string = va_arg(values, const char *), *end = string;
            while (*end) end++;
            put_padded(end, string, width);
        }
    }
}

int printf(const char *text, ...)
{
    va_list values;
    va_start(values, text);
    format(text, values);
    va_end(values);
    return 0;
}

void *stderr;

int fprintf(void *file, const char *text, ...)
{
    va_list values;
    (void)file;
    va_start(values, text);
    format(text, values);
    va_end(values);
    return 0;
}
