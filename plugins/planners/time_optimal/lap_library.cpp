#include "planners/time_optimal/lap_library.hpp"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace gripline::time_optimal {
namespace {

constexpr int most_iterations = 100;  // of a solve while driving
constexpr double version = 3;         // of the program that is solved and of the file; part of every hash

std::uint64_t hash_of(std::span<const double> values, std::uint64_t hash) {
  for (const double value : values)
    for (std::uint64_t bits = std::bit_cast<std::uint64_t>(value), i = 0; i < 8; ++i)
      hash = (hash ^ ((bits >> (8 * i)) & 0xff)) * 1099511628211ull;
  return hash;
}

/// 128 bits of FNV-1a as text: detects damage, not forgery.
template <class Hash>
std::string two_hashes(const Hash& hash) {
  char name[64];
  char* end = name;
  for (const std::uint64_t seed : {14695981039346656037ull, 1099511628211ull})
    end = std::to_chars(end, std::end(name), hash(seed), 16).ptr;
  return {name, end};
}

std::string checksum(std::string_view text) {
  return two_hashes([&](std::uint64_t hash) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
    return hash;
  });
}

std::filesystem::path cache_file(const LapSetup& setup, const CarBelief& typical, const std::vector<double>& mus,
                                 const char* cache_dir) {
  std::vector<double> all = setup.fingerprint();
  for (const MagicFormula& t : {typical.tyres.front, typical.tyres.rear}) all.insert(all.end(), {t.B, t.C, t.D});
  all.insert(all.end(), {typical.resistance.rolling, typical.resistance.drag});
  all.insert(all.end(), mus.begin(), mus.end());
  all.push_back(version);
  const std::string name = two_hashes([&](std::uint64_t seed) { return hash_of(all, seed); });
  return std::filesystem::path(cache_dir) / ("time_optimal-" + name + ".txt");
}

/// Every number on a line of its own, in the order in which `visit` meets them: sizes are known from the setup.
template <class Visit>
void visit_numbers(std::vector<LapMember>& members, std::size_t nodes, const Visit& visit) {
  for (LapMember& m : members) {
    m.solution.z.resize(nodes);
    for (auto& z : m.solution.z)
      for (double& one : z) visit(one);
    visit(m.solution.time);
    for (std::vector<double>* v : {&m.solution.lambda, &m.solution.lower, &m.solution.upper}) {
      double size = static_cast<double>(v->size());
      visit(size);
      if (!(size >= 0 && size <= 1e7)) size = 0;
      v->resize(static_cast<std::size_t>(size));
      for (double& one : *v) visit(one);
    }
  }
}

/// Laps that a solve could have found. What is no lap of any car must not be driven, whatever the checksum says.
bool plausible(const std::vector<LapMember>& members) {
  constexpr double longest = 1e5;   // [s]
  constexpr double largest = 1e15;  // of states, inputs and multipliers
  const auto good = [&](double value) { return std::isfinite(value) && std::abs(value) <= largest; };
  for (const LapMember& m : members) {
    if (!(m.solution.time > 0 && m.solution.time < longest)) return false;
    for (const auto& z : m.solution.z)
      if (!std::all_of(z.begin(), z.end(), good)) return false;
    for (const std::vector<double>* v : {&m.solution.lambda, &m.solution.lower, &m.solution.upper})
      if (!std::all_of(v->begin(), v->end(), good)) return false;
  }
  return true;
}

/// The checksum on the first line, the numbers on the others.
bool read_numbers(std::string_view text, std::size_t nodes, std::vector<LapMember>& members) {
  const std::size_t line = text.find('\n');
  if (line == std::string_view::npos) return false;
  const std::string_view body = text.substr(line + 1);
  if (text.substr(0, line) != checksum(body)) return false;
  const char* at = body.data();
  const char* const end = at + body.size();
  bool good = true;
  std::vector<LapMember> read = members;
  visit_numbers(read, nodes, [&](double& value) {
    if (!good) return;
    const auto [next, error] = std::from_chars(at, end, value);
    good = error == std::errc{} && next != end && *next == '\n';
    at = good ? next + 1 : at;
  });
  if (!good || at != end || !plausible(read)) return false;
  members = std::move(read);
  return true;
}

/// False without a file, and, with a word in the run's log, with a damaged one.
bool read_cache(const std::filesystem::path& path, std::size_t nodes, std::vector<LapMember>& members) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (read_numbers(text, nodes, members)) return true;
  std::cerr << "time_optimal: the laps kept in " << path.string() << " are damaged; they are computed anew\n";
  return false;
}

/// Written aside, on the disk, renamed: a reader finds the whole file or none. A cache that cannot be written is no
/// error.
void write_cache(const std::filesystem::path& path, std::size_t nodes, std::vector<LapMember>& members) {
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  std::string body;
  visit_numbers(members, nodes, [&](double& value) {
    char digits[40];
    const auto written = std::to_chars(digits, std::end(digits) - 1, value);
    *written.ptr = '\n';
    body.append(digits, written.ptr + 1);
  });
  const std::string text = checksum(body) + "\n" + body;
  std::string aside = path.string() + ".XXXXXX";
  const int file = mkstemp(aside.data());
  if (file < 0) return;
  bool good = true;
  for (std::string_view rest = text; good && !rest.empty();) {
    const ssize_t written = ::write(file, rest.data(), rest.size());
    good = written > 0;
    if (good) rest.remove_prefix(static_cast<std::size_t>(written));
  }
  good = fsync(file) == 0 && good;
  close(file);
  if (good) std::filesystem::rename(aside, path, ignored);
  if (!good || ignored) std::filesystem::remove(aside, ignored);
}

/// The member at `index`, warm from `neighbour` when there is one, else or when that fails from the base line.
void solve_member(const LapSetup& setup, LapMember& member, const LapMember* neighbour) {
  LapSolution solution;
  if (neighbour != nullptr) solution = solve_lap(setup.problem(member.belief), neighbour->solution);
  if (!solution.solved) solution = solve_lap(setup.problem(member.belief), setup.cold_guess(member.belief.tyres));
  if (!solution.solved)
    throw std::runtime_error("found no time-optimal lap at mu = " + std::to_string(member.mu) +
                             "; check the road's width, the margin and the car's limits");
  member.solution = std::move(solution);
}

}  // namespace

std::vector<LapMember> build_library(const LapSetup& setup, const CarBelief& typical, const std::vector<double>& mus,
                                     const char* cache_dir, const Progress& progress) {
  std::vector<LapMember> members(mus.size());
  for (std::size_t i = 0; i < mus.size(); ++i) {
    members[i].mu = mus[i];
    members[i].belief = {scaled_to(typical.tyres, mus[i]), typical.resistance};
  }
  const std::size_t nodes = setup.nodes().s.size();
  std::filesystem::path file;
  if (cache_dir != nullptr) file = cache_file(setup, typical, mus, cache_dir);
  if (cache_dir == nullptr || !read_cache(file, nodes, members)) {
    // The grippiest first: its tyres are furthest from sliding, where a cold start succeeds most easily.
    for (std::size_t i = mus.size(); i-- > 0;) {
      solve_member(setup, members[i], i + 1 < mus.size() ? &members[i + 1] : nullptr);
      const double done = static_cast<double>(mus.size() - i) / static_cast<double>(mus.size());
      if (progress.tell != nullptr) progress.tell(progress.context, "time-optimal lines", done);
    }
    if (cache_dir != nullptr) write_cache(file, nodes, members);
  }
  for (LapMember& m : members) m.plan = make_plan(setup, m.solution);
  return members;
}

SolveOutcome solve_again(const LapSetup& setup, const CarBelief& belief, LapMember& member) {
  SolveOutcome outcome;
  const auto attempt = [&](const LapSolution& from) {
    LapSolution solution = solve_lap(setup.problem(belief), from, most_iterations);
    outcome.work += static_cast<double>(setup.nodes().s.size()) * solution.iterations;
    outcome.solved = solution.solved;
    return solution;
  };
  LapSolution solution = attempt(member.solution);
  if (!solution.solved) {
    LapSolution primal = member.solution;
    primal.lambda.clear();
    solution = attempt(primal);
  }
  if (!outcome.solved) return outcome;
  member.belief = belief;
  member.solution = std::move(solution);
  member.plan = make_plan(setup, member.solution);
  return outcome;
}

}  // namespace gripline::time_optimal
