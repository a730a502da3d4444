#include "diagnose/result/case_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_case_file {

using test::DiagnoseRig;
using testing::HasSubstr;

TEST(CaseFile, WhatIsExcludedIsAnEffectThatCouldBeFound) {
  const DiagnoseRig rig;
  CaseOptions options;
  options.exclude = {"aero_drag"};
  EXPECT_NO_THROW(check_excluded(options, rig.catalogue()));
  options.exclude = {"aero_drag", "areo_drag"};
  EXPECT_THAT([&] { check_excluded(options, rig.catalogue()); },
              testing::ThrowsMessage<InputError>(
                  testing::AllOf(HasSubstr("\"exclude\" names \"areo_drag\""), HasSubstr("aero_drag\"?"))));
}

}  // namespace test_diagnose_case_file
}  // namespace gripline::diagnose
