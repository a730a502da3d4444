// gripline bench: how long steps take, and whether they allocate.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "bench.hpp"
#include "config/json_file.hpp"
#include "experiment.hpp"
#include "race_options.hpp"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
// The whole process allocates through these, plugins and Eigen included; they count and hand on.
namespace {
std::atomic<std::int64_t> allocation_count{0};
}
extern "C" void* __libc_malloc(std::size_t);                 // NOLINT(bugprone-reserved-identifier)
extern "C" void* __libc_memalign(std::size_t, std::size_t);  // NOLINT(bugprone-reserved-identifier)
extern "C" void* malloc(std::size_t size) {
  allocation_count.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  allocation_count.fetch_add(1, std::memory_order_relaxed);
  return __libc_memalign(alignment, size);
}
#define GRIPLINE_COUNTS_ALLOCATIONS 1
#endif

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

std::int64_t count_allocations() {
#ifdef GRIPLINE_COUNTS_ALLOCATIONS
  return allocation_count.load(std::memory_order_relaxed);
#else
  return 0;
#endif
}

void print(const BenchRow& row) {
  char line[200];
  std::snprintf(line, sizeof line, "%-22s %9.1f %9.1f %9.1f %8.2f %6.0f %12.2e %6d %9.4f", row.name.c_str(),
                row.median_us, row.p95_us, row.p99_us, row.allocations_per_step, row.iterations_median,
                row.first_input_error_p95, row.failures, row.ratio_to_mpc_ipopt);
  std::cout << line << '\n';
}

}  // namespace

int run_bench_command(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("out", po::value<std::string>(), "write the rows to this CSV file");
  add("world", po::value<std::string>()->default_value("worlds/ethz.json"), "the world that is driven");
  add("instances", po::value<int>()->default_value(200), "recorded problems");
  add("plugins", po::value<std::vector<std::string>>()->composing(), "a folder of plugins");
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "bench [--out F.csv] [options]");
  if (!given) return good;
  const int instances = (*given)["instances"].as<int>();
  if (instances < 20) throw InputError("--instances " + std::to_string(instances) + ": at least 20");
  std::vector<std::string> dirs;
  if (given->count("plugins") > 0) dirs = (*given)["plugins"].as<std::vector<std::string>>();
  const Registry registry(Registry::search_path(dirs));
  Node tree = load_json((*given)["world"].as<std::string>());
  inline_world_files(tree);
  Errors errors;
  const WorldSpec world = read_world(tree, registry, errors);
  errors.throw_if_any();
  const std::vector<BenchRow> rows = run_bench(world, registry, count_allocations, instances);
  std::cout
      << "case                   median us    p95 us    p99 us  allocs  iters  error p95    failed  ratio to Ipopt\n";
  for (const BenchRow& row : rows) print(row);
  if (given->count("out") > 0) write_bench((*given)["out"].as<std::string>(), rows);
  return good;
}

}  // namespace gripline::tools
