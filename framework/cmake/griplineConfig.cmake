include(${CMAKE_CURRENT_LIST_DIR}/griplineTargets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/GriplineAddPlugin.cmake)
# The program, for tests: COMMAND gripline::gripline plugins check $<TARGET_FILE:my_plugin>
get_filename_component(gripline_program ${CMAKE_CURRENT_LIST_DIR}/../../../bin/gripline ABSOLUTE)
if(NOT TARGET gripline::gripline AND EXISTS ${gripline_program})
  add_executable(gripline::gripline IMPORTED)
  set_target_properties(gripline::gripline PROPERTIES IMPORTED_LOCATION ${gripline_program})
endif()
