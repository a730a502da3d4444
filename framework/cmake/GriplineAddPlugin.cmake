# gripline_add_plugin(name source...): a plugin library that exports its manifest and nothing else.
# -fno-gnu-unique: inline statics of two plugins stay apart, and the library could be unloaded.
function(gripline_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  target_link_libraries(${name} PRIVATE gripline::plugin)
  target_compile_options(${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique> -fvisibility=hidden)
  set_target_properties(${name} PROPERTIES PREFIX "" POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF)
endfunction()
