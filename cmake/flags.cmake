# Flags of every target of this project. Errors out of warnings only when remaps is the top project.
add_library(remaps_flags INTERFACE)
target_compile_options(
  remaps_flags
  INTERFACE -ffp-contract=off
            -Wall
            -Wextra
            -Wpedantic
            -Wshadow
            -Wconversion
            -Wsign-conversion
            $<$<BOOL:${PROJECT_IS_TOP_LEVEL}>:-Werror>
            # GCC 12's vectorizer drops a double -> float -> double rounding.
            $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)
if(REMAPS_SANITIZE)
  target_compile_options(remaps_flags INTERFACE -fsanitize=${REMAPS_SANITIZE}
                                                -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(remaps_flags INTERFACE -fsanitize=${REMAPS_SANITIZE})
endif()
