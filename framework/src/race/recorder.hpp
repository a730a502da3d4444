// The files of one run: steps.csv, timing.csv, replay.csv, tyres.csv, line.csv (columns: framework/doc/columns.md).
#pragma once

#include <sys/types.h>

#include <memory>

#include "race/stack.hpp"
#include "util/csv_writer.hpp"
#include "world/world.hpp"

namespace gripline {

/// CPU time of one control step [ms].
struct StepTiming {
  double update_ms = 0, plan_ms = 0, solve_ms = 0;
};

/// Everything that is known after the controller decided at this instant.
struct StepRecord {
  const World& world;
  Stack& stack;
  const StackBelief& belief;
  std::span<const RefPoint> horizon;
  const Command& command;
  Input sent;  // within the car's limits
  double mu_true;
  StepTiming timing;
};

class Recorder {
 public:
  /// Makes the files in an existing folder.
  explicit Recorder(const std::filesystem::path& folder);
  void write(const StepRecord& record);
  /// Returns when all rows are on the disk. Throws std::runtime_error.
  void finish();

 private:
  void write_line(std::span<const LinePoint> line) const;
  void write_step(const StepRecord& record);
  void write_replay(const StepRecord& record);
  void write_tyres(const StepRecord& record);

  std::filesystem::path folder_;
  pid_t process_;
  CsvWriter steps_, timing_, replay_, tyres_;
};

}  // namespace gripline
