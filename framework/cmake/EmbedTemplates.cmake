# Turns the files of a folder into one source file of raw strings: cmake -DFOLDER= -DOUTPUT= -P EmbedTemplates.cmake
file(GLOB files ${FOLDER}/*)
set(entries "")
foreach(file ${files})
  file(READ ${file} text)
  get_filename_component(name ${file} NAME)
  string(APPEND entries "    {\"${name}\", R\"gripline~(${text})gripline~\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Generated from tools/templates.
#include \"gripline/new_plugin.hpp\"

namespace gripline::tools {

std::span<const Template> templates() {
  static constexpr Template all[] = {
${entries}  };
  return all;
}

}  // namespace gripline::tools
")
