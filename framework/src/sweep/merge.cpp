#include "sweep/merge.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "util/csv_cell.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

/// Numbers texts in the order in which they come.
class Levels {
 public:
  std::uint32_t of(const std::string& text, std::vector<std::string>& all) {
    const auto [found, fresh] = known_.try_emplace(text, static_cast<std::uint32_t>(all.size()));
    if (fresh) all.push_back(text);
    return found->second;
  }

 private:
  std::unordered_map<std::string, std::uint32_t> known_;
};

/// The first 64 bits of a hash tell the drives of a sweep apart as well as all of it; 0 where there is none.
std::uint64_t drive_number(const std::string& hash) {
  std::uint64_t number = 0;
  std::from_chars(hash.data(), hash.data() + std::min<std::size_t>(hash.size(), 16), number, 16);
  return number;
}

/// Fills the table with one run after another.
class Filler {
 public:
  Filler(const Sweep& sweep, Table& table) : sweep_(sweep), table_(table) {
    table.factors = {"experiment"};
    for (const Factor& factor : sweep.design.factors()) table.factors.push_back(factor.pointer);
    table.factors.emplace_back("stack");
    table.levels.resize(table.factors.size());
    table.level.resize(table.factors.size());
    levels_.resize(table.factors.size());
  }

  void add(const RunAt& run, const Record& record) {
    if (table_.rows() == 0 || setting_ != run.setting) values_ = sweep_.design.setting(setting_ = run.setting);
    put(0, sweep_.parts[run.part].name);
    for (std::size_t f = 0; f < values_.size(); ++f) put(f + 1, values_[f]);
    put(values_.size() + 1, sweep_.row_of(run));
    table_.seed.push_back(run.seed);
    table_.drive.push_back(drive_number(record.drive));
    table_.repeats.push_back(is_repeat(run, table_.drive.back()));
    table_.broken.push_back(record.broken());
    for (const auto& [name, value] : record.values) {
      const auto [found, fresh] = responses_.try_emplace(name, table_.responses.size());
      if (fresh) {
        table_.responses.push_back(name);
        table_.value.emplace_back(table_.rows() - 1, not_a_number);
      }
      table_.value[found->second].resize(table_.rows() - 1, not_a_number);
      table_.value[found->second].push_back(value);
    }
  }

  void finish() {
    for (std::vector<double>& column : table_.value) column.resize(table_.rows(), not_a_number);
  }

 private:
  void put(std::size_t factor, const std::string& text) {
    table_.level[factor].push_back(levels_[factor].of(text, table_.levels[factor]));
  }

  /// Whether a run of the same experiment, setting and row did the same; these come one after another.
  bool is_repeat(const RunAt& run, std::uint64_t drive) {
    const std::array<std::size_t, 3> place = {run.part, run.setting, run.row};
    if (place != place_) drives_.clear();
    place_ = place;
    return drive != 0 && !drives_.insert(drive).second;
  }

  const Sweep& sweep_;
  Table& table_;
  std::vector<Levels> levels_;
  std::unordered_map<std::string, std::size_t> responses_;
  std::vector<std::string> values_;
  std::size_t setting_ = 0;
  std::array<std::size_t, 3> place_{};        // of the last run
  std::unordered_set<std::uint64_t> drives_;  // there
};

void put_number(CsvWriter& csv, double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15)
    csv << static_cast<std::int64_t>(value);
  else
    csv << value;
}

double time_of(const Record& record, std::string_view name) {
  for (const auto& [known, value] : record.times)
    if (known == name) return value;
  return not_a_number;
}

struct RowHead {
  std::uint64_t run;
  std::string status;
};

void write_table(const fs::path& out, const Table& table, const std::vector<RowHead>& heads) {
  std::string header = "run";
  for (const std::string& factor : table.factors) header += "," + csv_cell(factor);
  header += ",seed,status";
  for (const std::string& response : table.responses) header += "," + csv_cell(response);
  WholeFile file(out / "table.csv");
  CsvWriter csv(file, header);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    csv << static_cast<std::int64_t>(heads[row].run);
    for (std::size_t f = 0; f < table.factors.size(); ++f)
      csv << std::string_view(csv_cell(table.levels[f][table.level[f][row]]));
    csv << static_cast<std::int64_t>(table.seed[row]) << std::string_view(heads[row].status);
    for (const std::vector<double>& column : table.value) put_number(csv, column[row]);
    csv.end_row();
  }
  file.finish();
}

}  // namespace

double Table::counted(std::size_t response, std::size_t row) const {
  return broken[row] && responses[response] != "finished" ? not_a_number : value[response][row];
}

MergeOutcome merge_records(const fs::path& out, const Sweep& sweep, Table& table,
                           const std::function<void(std::size_t, std::size_t)>& progress) {
  const KeyFile keys(out, sweep);
  const Store store(out);
  MergeOutcome outcome;
  outcome.runs = sweep.size();
  Filler filler(sweep, table);
  std::vector<RowHead> heads;
  WholeFile timing_file(out / "timing.csv"), missing_file(out / "missing.csv");
  CsvWriter timing(timing_file, "run,cpu_s,solve_ms_median,solve_ms_p99,node");
  CsvWriter missing(missing_file, "run,experiment,setting,stack,seed,what,message");
  const auto note_missing = [&](const RunAt& run, std::string_view what, const std::string& message) {
    missing << static_cast<std::int64_t>(run.index) << std::string_view(csv_cell(sweep.parts[run.part].name))
            << static_cast<std::int64_t>(run.setting) << std::string_view(csv_cell(sweep.row_of(run)))
            << static_cast<std::int64_t>(run.seed) << what << std::string_view(csv_cell(message));
    missing.end_row();
  };
  for (std::size_t i = 0; i < outcome.runs; ++i) {
    const RunAt run = sweep.at(i);
    const std::string key = keys.key(i);
    const std::optional<Record> record = store.read(key);
    if (progress) progress(i, outcome.runs);
    if (!record) {
      ++outcome.missing;
      note_missing(run, "missing", store.why_missing(key));
      continue;
    }
    if (record->broken()) {
      ++outcome.broken;
      note_missing(run, record->status, record->message);
    } else {
      ++outcome.finished;
    }
    filler.add(run, *record);
    heads.push_back({i, record->status});
    const double cpu = time_of(*record, "cpu_s");
    if (std::isfinite(cpu)) outcome.cpu_s += cpu;
    timing << static_cast<std::int64_t>(i) << cpu << time_of(*record, "solve_ms_median")
           << time_of(*record, "solve_ms_p99") << std::string_view(csv_cell(record->node));
    timing.end_row();
  }
  filler.finish();
  write_table(out, table, heads);
  timing_file.finish();
  missing_file.finish();
  return outcome;
}

}  // namespace gripline::sweep
