# Libraries of single plugins beyond the SDK and Eigen.
target_link_libraries(mpc_ipopt_parts PUBLIC PkgConfig::IPOPT)
target_link_libraries(time_optimal_parts PUBLIC PkgConfig::IPOPT)
