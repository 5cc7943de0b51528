/* Statuses in words, and versions. */

#include "check.h"

int main(void) {
    const int32_t numbers[] = {-1, VOLGRAD_ERROR_NO_GRADIENT + 1, INT32_MIN, INT32_MAX};
    for (int32_t i = VOLGRAD_OK; i <= VOLGRAD_ERROR_NO_GRADIENT; i++) {
        const char *text = volgrad_status_message(i);
        CHECK(text != NULL && *text != '\0' && strcmp(text, volgrad_status_message(-1)) != 0);
    }
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        const char *text = volgrad_status_message(numbers[i]);
        CHECK(text != NULL && *text != '\0');
    }
    unsigned major, minor, patch;
    CHECK(volgrad_abi_version() == VOLGRAD_ABI_VERSION);
    CHECK(sscanf(volgrad_version(), "%u.%u.%u", &major, &minor, &patch) == 3);
    return check_end();
}
