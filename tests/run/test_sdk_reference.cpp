// The reference of the SDK: everything public is documented. WARN_AS_ERROR stands in the Doxyfile.
#include <gtest/gtest.h>

#include "support/program.hpp"

namespace gripline {
namespace test_sdk_reference {

using namespace testing_support;

TEST(SdkReference, DocumentsEverythingPublic) {
  const Folder folder;
  write_text(folder / "Doxyfile", contents(source_dir() / "framework/doc/Doxyfile") +
                                      "\nOUTPUT_DIRECTORY = " + folder.path().string() + "\n");
  Call call;
  call.folder = source_dir();
  const Outcome outcome = run_program({"doxygen", folder / "Doxyfile"}, call);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(std::filesystem::exists(folder / "html/index.html"));
}

}  // namespace test_sdk_reference
}  // namespace gripline
