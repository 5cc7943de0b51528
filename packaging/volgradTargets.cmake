# volgrad::volgrad is the shared library, volgrad::static the static one with what it needs, and volgrad::core the one for programs without
# an operating system, which has no volgrad_exr_*. They are in volgrad_LIBRARY_DIR, and their headers in volgrad_INCLUDE_DIR.

foreach(name volgrad static core)
    if(TARGET volgrad::${name})
        return()
    endif()
endforeach()

add_library(volgrad::volgrad SHARED IMPORTED GLOBAL)
set_target_properties(volgrad::volgrad PROPERTIES IMPORTED_LOCATION "${volgrad_LIBRARY_DIR}/libvolgrad.so")
add_library(volgrad::static STATIC IMPORTED GLOBAL)
set_target_properties(volgrad::static PROPERTIES
    IMPORTED_LOCATION "${volgrad_LIBRARY_DIR}/libvolgrad.a" INTERFACE_LINK_LIBRARIES "gcc_s;pthread;dl;m")
add_library(volgrad::core STATIC IMPORTED GLOBAL)
set_target_properties(volgrad::core PROPERTIES IMPORTED_LOCATION "${volgrad_LIBRARY_DIR}/libvolgrad_core.a")

foreach(name volgrad static core)
    set_target_properties(volgrad::${name} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${volgrad_INCLUDE_DIR}")
endforeach()
