include(${CMAKE_CURRENT_LIST_DIR}/griplineTargets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/GriplineAddPlugin.cmake)
