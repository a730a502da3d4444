#include "report/bundle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "config/hash.hpp"
#include "support/paths.hpp"
#include "support/report_files.hpp"

namespace gripline::report {
namespace test_report_bundle {

using testing::HasSubstr;
using testing::Not;

const fs::path source = testing_support::source_dir() / "tools" / "report";

TEST(ReportBundle, IsTheCommittedOne) {
  EXPECT_EQ(bundled_script(), bytes_of(source / "dist" / "report.js"));
  EXPECT_EQ(bundled_style(), bytes_of(source / "dist" / "report.css"));
  EXPECT_GT(bundled_script().size(), 50000u);
}

TEST(ReportBundle, WasBuiltFromTheSourceBesideIt) {
  std::map<std::string, std::string> files;  // sorted as build.mjs does
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(source / "src"))
    if (entry.path().extension() == ".ts" || entry.path().extension() == ".css")
      files["src/" + fs::relative(entry.path(), source / "src").generic_string()] = bytes_of(entry.path());
  for (const char* name : {"build.mjs", "package-lock.json"}) files[name] = bytes_of(source / name);
  std::string all;
  for (const auto& [name, text] : files) all += name + "\n" + std::to_string(text.size()) + "\n" + text;
  const std::string stamp = "source " + sha256_hex(all);
  EXPECT_THAT(std::string(bundled_script().substr(0, 200)), HasSubstr(stamp))
      << "tools/report/dist is older than its source; run: (cd tools/report && npm ci && npm run build)";
  EXPECT_THAT(std::string(bundled_style().substr(0, 200)), HasSubstr(stamp));
}

TEST(ReportBundle, CannotEndItsScript) {
  EXPECT_THAT(std::string(bundled_script()), Not(HasSubstr("</script")));
  EXPECT_THAT(std::string(bundled_style()), Not(HasSubstr("</style")));
}

}  // namespace test_report_bundle
}  // namespace gripline::report
