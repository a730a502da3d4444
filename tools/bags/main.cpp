// gripline-bags, the program behind `gripline import` of a recording of ROS: apart, so that only it needs the libraries
// that such recordings are read with.
#include "bags/open_bag.hpp"
#include "gripline/import_bag.hpp"

namespace gripline::tools {
namespace {

int import_bag(Arguments args) { return import_log(args, &open_bag); }

}  // namespace
}  // namespace gripline::tools

int main(int argc, char** argv) {
  return gripline::tools::run_program(argc, argv, gripline::tools::import_bag, "gripline import");
}
