// gripline-hdf5, the program behind `gripline export --hdf5`: apart, so that only it needs the HDF5 library.
#include <iostream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "hdf5/hdf5_tables.hpp"

namespace gripline::tools {
namespace {

int export_tables(Arguments args) {
  if (args.size() != 2) throw InputError("usage: gripline-hdf5 RESULTS FILE (gripline export RESULTS --hdf5 FILE)");
  std::string groups;
  for (const std::string& group : write_hdf5(args[0], args[1]))
    groups.append(groups.empty() ? "/" : ", /").append(group);
  std::cout << "hdf5: " << args[1] << " (" << groups << ")\n";
  return good;
}

}  // namespace
}  // namespace gripline::tools

int main(int argc, char** argv) {
  return gripline::tools::run_program(argc, argv, gripline::tools::export_tables, "gripline export");
}
