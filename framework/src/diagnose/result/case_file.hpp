// case.json: what is known of a log besides the log (framework/doc/diagnose-cases.md).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/node.hpp"
#include "config/reader.hpp"
#include "diagnose/model/candidates.hpp"
#include "measured/log/log.hpp"

namespace gripline::diagnose {

struct CaseOptions {
  std::vector<std::string> exclude;           // effects that must not be named
  std::map<std::string, double> uncertainty;  // nominal parameter -> relative standard deviation; "Cr0_over_m" in m/s2
  /// Relative standard deviations of a world's unknowns, for where nothing else is said; names that the model has not
  /// are left alone.
  std::map<std::string, double> guessed;
  std::optional<measured::Channels> noise_sigma;  // of the sensors; default: the world's
};

/// The keys exclude, nominal_uncertainty, noise_sigma, vehicle and track; `track` is resolved beside the case or in
/// ../../tracks.
struct CaseFile {
  CaseOptions options;
  std::optional<std::filesystem::path> track;
  std::string vehicle;
};
/// Throws InputError.
CaseFile read_case(const std::filesystem::path& file);
/// The object nominal_uncertainty, of a case or of a world.
void read_uncertainty(const Node& node, CaseOptions& options, Errors& errors);
/// What a world says it does not know: its plant's parameters among the unknowns of fit, and nominal_uncertainty.
void read_uncertainty_of_world(const Node& world, CaseOptions& options, Errors& errors);
/// Throws InputError, with the nearest id, where options.exclude has one that is not a candidate.
void check_excluded(const CaseOptions& options, const Catalogue& catalogue);

}  // namespace gripline::diagnose
