#include "measured/session/gripline_log.hpp"

#include <charconv>
#include <cmath>

#include "measured/session/centre_of_gravity.hpp"
#include "util/numbers.hpp"
#include "util/whole_file.hpp"

namespace gripline::measured {
namespace {

void append(std::string& line, double value, int digits) {
  line += ',';
  if (std::isnan(value)) return;
  char buffer[64];
  const auto [end, code] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits);
  if (code == std::errc()) line.append(buffer, end);
}

/// Of a group of which no delay is known. A table of health may have one of it against a command, which says how the car
/// answers and not how late the channel is.
std::string no_delay_text(std::size_t group) {
  const char* const against =
      delay_names[group == delay_group[Channel::yaw_rate] ? delay_group[Channel::yaw] : delay_group[Channel::x]];
  return std::string(delay_names[group]) + ": no delay against " + against +
         " could be found, so none is taken off (one against a command is the car's own response too)";
}

}  // namespace

std::vector<std::string> write_gripline_log(const std::filesystem::path& file, const SessionFile& from,
                                            std::array<double, delay_groups> delays) {
  constexpr std::array<int, channels> digits = {6, 6, 7, 6, 6, 7};
  const Session& s = from.session;
  std::vector<std::string> done;
  for (std::size_t g = 0; g < delay_groups; ++g) {
    if (std::isnan(delays[g])) {
      done.push_back(no_delay_text(g));
      delays[g] = 0.0;
    } else if (std::abs(delays[g]) < shortest_delay) {
      delays[g] = 0.0;
    } else {
      done.push_back(std::string(delay_names[g]) + ": " + significant(delays[g]) + " s taken off");
    }
  }
  std::string out = "t_s";
  for (std::size_t c = 0; c < channels; ++c)
    if (s.has[c]) out += std::string(",") + source_info(static_cast<Source>(c)).column;
  out += from.has_throttle ? ",d,delta_rad\n" : ",delta_rad\n";
  const Session own = at_centre_of_gravity(from, delays);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    std::string line;
    append(line, s.begin + s.t[i], 6);
    out.append(line, 1);
    for (std::size_t c = 0; c < channels; ++c) {
      line.clear();
      append(line, own.at(i, c), digits[c]);
      if (s.has[c]) out += line;
    }
    line.clear();
    if (from.has_throttle) append(line, s.command[i].d, 6);
    append(line, s.command[i].delta, 7);
    out += line + '\n';
  }
  write_file(file, out);
  return done;
}

}  // namespace gripline::measured
