#include "diagnose/result/uncertain_parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_uncertain_parameters {

using test::DiagnoseRig;
using testing::HasSubstr;

/// The message with which a case is refused; empty where it is not.
template <class Check>
std::string refused(const Check& check) {
  try {
    check();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(UncertainParameters, DeviationsAreOfTheParametersThemselves) {
  const DiagnoseRig rig({}, {}, R"({"plant": {"params": {"Cd": 0}}})");
  CaseOptions options;
  options.uncertainty = {{"Cd", 0.001}, {"Cr0_over_m", 0.06}, {"Df", 0.02}, {"Dr", 0.0}};
  const std::vector<Nuisance> found = uncertain_parameters(options, rig.catalogue());
  ASSERT_EQ(found.size(), 3U) << "one without a deviation is known";
  EXPECT_EQ(found[0].name, "Cd");
  EXPECT_DOUBLE_EQ(found[0].sigma, 0.001) << "of nothing no share is anything";
  EXPECT_EQ(found[1].name, "Cr0");
  EXPECT_DOUBLE_EQ(found[1].nominal, 0.0518);
  EXPECT_DOUBLE_EQ(found[1].sigma, 0.06 * rig.catalogue().car().m);
  EXPECT_EQ(found[2].name, "Df");
  EXPECT_DOUBLE_EQ(found[2].sigma, 0.02 * 0.192);
}

/// A world's unknowns are of its effects too: what the model has not is no mistake there.
TEST(UncertainParameters, GuessesCountWhereNothingIsStatedAndMayNameOtherThings) {
  const DiagnoseRig rig;
  CaseOptions options;
  options.guessed = {{"Df", 0.1}, {"tau", 0.1}};
  const std::vector<Nuisance> guessed = uncertain_parameters(options, rig.catalogue());
  ASSERT_EQ(guessed.size(), 1U);
  EXPECT_EQ(guessed.front().name, "Df");
  options.uncertainty = {{"Dr", 0.02}};
  const std::vector<Nuisance> stated = uncertain_parameters(options, rig.catalogue());
  ASSERT_EQ(stated.size(), 1U);
  EXPECT_EQ(stated.front().name, "Dr");
  options.uncertainty = {{"tau", 0.02}};
  EXPECT_THAT(refused([&] { (void)uncertain_parameters(options, rig.catalogue()); }),
              HasSubstr("nominal_uncertainty names \"tau\""));
}

}  // namespace test_diagnose_uncertain_parameters
}  // namespace gripline::diagnose
