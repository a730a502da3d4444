#include <iostream>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "gripline/command.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {
namespace {

struct CommandEntry {
  const char* name;
  int (*run)(Arguments);
  const char* summary;
};

constexpr CommandEntry commands[] = {
    {"compare", run_compare, "race every stack of an experiment and print the table"},
    {"run", run_one, "one stack and one seed of an experiment"},
    {"sweep", run_sweep, "thousands of runs: settings x stacks x seeds, here or on a Slurm cluster"},
    {"validate", run_validate, "read files whole and say everything that is wrong with them"},
    {"report", run_report, "redraw the report of a results folder; runs nothing"},
    {"export", run_export, "results for Foxglove and PlotJuggler, or a video of the replay"},
    {"columns", run_columns, "what the columns of the results mean"},
    {"diagnose", run_diagnose, "name the effect that is missing between a world and a log"},
    {"predict", run_predict, "how far a world's model is off a log, by horizon"},
    {"import", run_import, "a logger's table or a bag of ROS in gripline's columns, and how healthy it is"},
    {"fit", run_fit, "find a world's unknowns from logs"},
    {"limit", run_limit, "the fastest laps that a world's car can drive, over friction"},
    {"track", run_track, "a road from the formats that people have, repaired, checked and drawn"},
    {"bench", run_bench_command, "how long the steps of a stack take"},
    {"plugins", run_plugins, "list, describe, make (new) and check plugins"},
};

void print_help(std::ostream& out) {
  out << "gripline: race estimators and controllers at the limit of grip\n\nusage: gripline COMMAND ...\n\n";
  for (const CommandEntry& command : commands)
    out << "  " << command.name << std::string(12 - std::string(command.name).size(), ' ') << command.summary << '\n';
  out << "\n  --help      this text; after a command, that command's options\n  --version   the version\n\n"
         "exit: 0 good; 1 a claim failed, a plugin failed a check, or diagnose could not decide; 2 your input;\n"
         "      3 a plugin cannot be found, loaded or made; 4 a run broke;\n"
         "      75 runs of a sweep are missing and --resume may have them\n";
}

int dispatch(Arguments args) {
  if (args.empty()) {
    print_help(std::cerr);
    return bad_input;
  }
  if (args[0] == "--help" || args[0] == "-h" || args[0] == "help") {
    print_help(std::cout);
    return good;
  }
  if (args[0] == "--version") {
    std::cout << "gripline " << GRIPLINE_VERSION << " (plugin ABI " << abi::number << ")\n";
    return good;
  }
  std::vector<std::string> names;
  for (const CommandEntry& command : commands) {
    if (args[0] == command.name) return command.run(args.subspan(1));
    names.emplace_back(command.name);
  }
  throw InputError("no command \"" + args[0] + "\"" + did_you_mean(args[0], names));
}

}  // namespace
}  // namespace gripline::tools

int main(int argc, char** argv) {
  return gripline::tools::run_program(argc, argv, gripline::tools::dispatch, "gripline ");
}
