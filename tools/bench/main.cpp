// gripline-bench, the program behind `gripline bench`: how long steps take, and whether they allocate.
#include <iostream>

#include "bench/bench.hpp"
#include "cli/options.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "util/allocation_counter.hpp"
#include "util/numbers.hpp"

namespace gripline::tools {
namespace {

namespace po = boost::program_options;

constexpr std::int64_t most_instances = 100'000;

std::int64_t count_allocations() { return allocations.load(std::memory_order_relaxed); }

void print(const BenchRow& row) {
  std::cout << format("%-22s %9.1f %9.1f %9.1f %9.1f %8.2f %6.0f %12.2e %12.2e %6d %9.4f\n", row.name.c_str(),
                      row.median_us, row.p95_us, row.p99_us, row.max_us, row.allocations_per_step,
                      row.iterations_median, row.first_input_error_p95, row.first_input_error_max, row.failures,
                      row.ratio_to_mpc_ipopt);
}

int run(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("out", po::value<std::string>(), "write the rows to this CSV file");
  add("world", po::value<std::string>()->default_value("worlds/ethz.json"), "the world that is driven");
  add("instances", po::value<std::string>()->default_value("200"), "recorded problems");
  add("controller", po::value<Words>()->composing(),
      "one that is compared instead of mpc_ipopt and mpc_sqp; it must know their cost parameters; may be repeated");
  add_plugins_option(visible);
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "bench [--out F.csv] [options]", "unexpected");
  if (!given) return good;
  if (const Words unexpected = words_of(*given, "unexpected"); !unexpected.empty())
    throw InputError("bench takes no file: \"" + unexpected.front() + "\"; a world is given by --world");
  const std::int64_t instances =
      whole_number("--instances", (*given)["instances"].as<std::string>(), {20, most_instances});
  const std::string world_file = find_shipped((*given)["world"].as<std::string>(), "worlds").string();
  const std::optional<std::string> out = text_of(*given, "out");
  if (out) require_writable("--out", *out, std::span(&world_file, 1));
  const Registry registry = open_registry(plugin_dirs_of(*given));
  const Node tree = load_world(world_file);
  Errors errors;
  const WorldSpec world = read_world(tree, registry, errors);
  errors.throw_if_any();
  BenchOptions options;
  options.instances = static_cast<int>(instances);
  if (const Words controllers = words_of(*given, "controller"); !controllers.empty()) options.controllers = controllers;
  const std::vector<BenchRow> rows = [&] {
    CallbackProgress progress(std::cerr, "bench");
    std::vector<BenchRow> measured = run_bench(world, registry, count_allocations, options, progress.callback());
    progress.finish();
    return measured;
  }();
  std::cout << "case                   median us    p95 us    p99 us    max us   allocs  iters    error p95    error "
               "max failed "
               " of Ipopt\n";
  for (const BenchRow& row : rows) print(row);
  if (out) write_bench(*out, rows);
  return good;
}

}  // namespace
}  // namespace gripline::tools

int main(int argc, char** argv) {
  return gripline::tools::run_program(argc, argv, gripline::tools::run, "gripline bench");
}
