#include "config/assignment_errors.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace gripline {
namespace test_assignment_errors {

/// Reads that go wrong as soon as certain assignments are there.
void read(std::span<const std::string> assignments) {
  std::vector<Diagnostic> found = {{"a.json", 1, 2, "/own", "wrong from the start", {}}};
  const auto has = [&](const char* text) {
    return std::find(assignments.begin(), assignments.end(), text) != assignments.end();
  };
  if (has("/x=1")) found.push_back({"--set", 0, 0, "/x", "too small", {}});
  if (has("/y/z=null")) found.push_back({"a.json", 7, 3, "/y", "\"z\" is missing", {"stack s"}});
  throw InputError(found);
}

std::string told(const std::vector<std::string>& assignments) {
  try {
    read(assignments);
  } catch (const InputError& error) {
    return attribute_to_assignments(error, assignments, read).what();
  }
  return "nothing";
}

TEST(AssignmentErrors, AnErrorIsToldAtTheAssignmentThatMakesIt) {
  const std::string own = "a.json:1:2: /own: wrong from the start";
  EXPECT_EQ(told({}), own);
  EXPECT_EQ(told({"/harmless=1"}), own);
  EXPECT_EQ(told({"/x=1"}), own + "\n--set /x: too small");
  EXPECT_EQ(told({"/x=1", "/y/z=null", "/harmless=1"}),
            own + "\n--set /x: too small\n--set /y/z: \"z\" is missing (a.json:7:3: /y) [stack s]");
}

}  // namespace test_assignment_errors
}  // namespace gripline
