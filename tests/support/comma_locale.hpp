// A locale with decimal commas, as a program that hosts this library may have set. It is made for the test: most
// machines have none, and without one printf writes points whatever a test asks for.
#pragma once

#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/program.hpp"
#include "util/temporary_folder.hpp"

namespace gripline::testing_support {

/// The process's locale while it lives. Children take it with LC_ALL=name() and LOCPATH=folder().
class CommaLocale {
 public:
  CommaLocale() : before_(std::setlocale(LC_ALL, nullptr)) {
    if (const char* const path = std::getenv("LOCPATH"); path != nullptr) path_before_ = path;
    said_ = run_program({"localedef", "-i", "de_DE", "-f", "UTF-8", folder_.path() / name()}).err;
    setenv("LOCPATH", folder_.path().c_str(), 1);
    is_set_ = std::setlocale(LC_ALL, name()) != nullptr && *std::localeconv()->decimal_point == ',';
  }
  ~CommaLocale() {
    std::setlocale(LC_ALL, before_.c_str());
    path_before_.empty() ? unsetenv("LOCPATH") : setenv("LOCPATH", path_before_.c_str(), 1);
  }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;
  static const char* name() { return "de_DE.UTF-8"; }
  const std::filesystem::path& folder() const { return folder_.path(); }
  bool is_set() const { return is_set_; }
  /// Whether tests are skipped where no such locale can be made.
  static bool may_be_missing() { return std::getenv("GRIPLINE_REQUIRE_REFERENCE") == nullptr; }
  std::string problem() const { return "localedef (Debian: locales) makes no locale with decimal commas: " + said_; }

 private:
  TemporaryFolder folder_{"locale"};
  std::string before_, path_before_, said_;
  bool is_set_ = false;
};

/// A test in that locale: skipped where none can be made, unless GRIPLINE_REQUIRE_REFERENCE is set.
class InCommaLocale : public testing::Test {
 protected:
  void SetUp() override {
    if (!locale_.is_set() && CommaLocale::may_be_missing()) GTEST_SKIP() << locale_.problem();
    ASSERT_TRUE(locale_.is_set()) << locale_.problem();
  }
  CommaLocale locale_;
};

}  // namespace gripline::testing_support
