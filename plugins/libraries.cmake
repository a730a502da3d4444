# Libraries of single plugins beyond the SDK and Eigen.
foreach(name mpc_ipopt time_optimal)
  if(TARGET ${name})
    target_link_libraries(${name} PRIVATE PkgConfig::IPOPT)
  endif()
endforeach()
