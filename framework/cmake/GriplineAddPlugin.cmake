# gripline_add_plugin(name source...): a plugin library that exports its manifest and nothing else.
# -fno-gnu-unique: inline statics of two plugins stay apart, and the library could be unloaded.
# Optimised where no CMAKE_BUILD_TYPE is given: a control step takes three times as long without.
function(gripline_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  target_link_libraries(${name} PRIVATE gripline::plugin)
  target_compile_options(${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique> -fvisibility=hidden
    "$<$<CONFIG:>:-O2;-DNDEBUG>")
  set_target_properties(${name} PROPERTIES PREFIX "" POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF)
endfunction()
