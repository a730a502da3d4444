// gripline export --hdf5: read back by the HDF5 library. Where gripline was built without it, the command says so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "support/program.hpp"
#ifdef GRIPLINE_HDF5
#include <hdf5.h>
#endif

namespace gripline {
namespace test_export_hdf5 {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::ElementsAre;
using testing::HasSubstr;

class ExportHdf5 : public testing::Test {
 protected:
  ExportHdf5() {
    fs::create_directories(out_);
    std::ofstream(out_ / "table.csv") << "stack,/base/mu_init,finished,lap1_s\nelm,0.8,1,7.5\n\"a, b\",1,0,\n";
    std::ofstream(out_ / "pairs.csv") << "stack,difference\n";
  }
  Outcome export_to(const fs::path& file) const { return gripline_with({"export", out_, "--hdf5", file}); }
  Folder folder_;
  fs::path out_ = folder_ / "out", file_ = folder_ / "out.h5";
};

#ifdef GRIPLINE_HDF5

/// Closed by the end of the test program only.
hid_t dataset_of(hid_t file, const char* name) { return H5Dopen2(file, name, H5P_DEFAULT); }

hsize_t rows_of(hid_t dataset) {
  hsize_t rows = 0;
  H5Sget_simple_extent_dims(H5Dget_space(dataset), &rows, nullptr);
  return rows;
}

std::vector<double> numbers_of(hid_t file, const char* name) {
  const hid_t dataset = dataset_of(file, name);
  std::vector<double> values(rows_of(dataset));
  EXPECT_GE(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << name;
  return values;
}

hid_t text_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

std::vector<std::string> texts_of(hid_t file, const char* name) {
  const hid_t dataset = dataset_of(file, name);
  std::vector<char*> cells(rows_of(dataset));
  EXPECT_GE(H5Dread(dataset, text_type(), H5S_ALL, H5S_ALL, H5P_DEFAULT, cells.data()), 0) << name;
  return {cells.begin(), cells.end()};
}

std::string attribute_of(hid_t file, const char* dataset, const char* name) {
  const hid_t attribute = H5Aopen(dataset_of(file, dataset), name, H5P_DEFAULT);
  char* text = nullptr;
  EXPECT_GE(H5Aread(attribute, text_type(), &text), 0) << name;
  return text == nullptr ? "" : text;
}

TEST_F(ExportHdf5, EveryTableIsAGroupAndEveryColumnADataset) {
  const Outcome outcome = export_to(file_);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "hdf5: " + file_.string() + " (/pairs, /table)\n");
  const hid_t file = H5Fopen(file_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  EXPECT_THAT(texts_of(file, "/table/stack"), ElementsAre("elm", "a, b"));
  EXPECT_THAT(numbers_of(file, "/table/base.mu_init"), ElementsAre(0.8, 1.0));
  EXPECT_EQ(attribute_of(file, "/table/base.mu_init", "column"), "/base/mu_init");
  const std::vector<double> laps = numbers_of(file, "/table/lap1_s");
  ASSERT_EQ(laps.size(), 2u);
  EXPECT_EQ(laps[0], 7.5);
  EXPECT_TRUE(std::isnan(laps[1])) << "an empty cell";
  EXPECT_EQ(attribute_of(file, "/table/lap1_s", "unit"), "s");
  EXPECT_TRUE(numbers_of(file, "/pairs/difference").empty()) << "a table without rows";
}

/// Chunks and compression begin at 1024 rows; more than one chunk at 32768.
TEST_F(ExportHdf5, ATableOfManyRunsComesBackWhole) {
  std::ofstream table(out_ / "table.csv");
  table << "run,seed\n";
  constexpr int rows = 70'000;
  for (int row = 0; row < rows; ++row) table << row << ',' << row % 50 << '\n';
  table.close();
  ASSERT_EQ(export_to(file_).code, 0);
  const hid_t file = H5Fopen(file_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const std::vector<double> runs = numbers_of(file, "/table/run");
  ASSERT_EQ(runs.size(), std::size_t{rows});
  for (int row = 0; row < rows; ++row) ASSERT_EQ(runs[static_cast<std::size_t>(row)], row);
  EXPECT_LT(fs::file_size(file_), fs::file_size(out_ / "table.csv")) << "not compressed";
}

TEST_F(ExportHdf5, TwoColumnsOfOneNameLeaveNoFile) {
  std::ofstream(out_ / "table.csv") << "/base/a,base.a\n1,2\n";
  const Outcome outcome = export_to(file_);
  EXPECT_NE(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("table.csv, column \"base.a\": there is already a dataset \"base.a\""));
  EXPECT_FALSE(fs::exists(file_));
  EXPECT_FALSE(fs::exists(file_.string() + ".partial"));
}

TEST_F(ExportHdf5, AFolderWithoutTablesIsRefused) {
  fs::remove(out_ / "table.csv");
  fs::remove(out_ / "pairs.csv");
  const Outcome outcome = export_to(file_);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("no table; expected a folder that compare or sweep wrote"));
}

#else

TEST_F(ExportHdf5, SaysThatItWasBuiltWithoutTheLibrary) {
  const Outcome outcome = export_to(file_);
  EXPECT_NE(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("export --hdf5 (HDF5 when gripline was built) needs the program gripline-hdf5"));
}

#endif

}  // namespace test_export_hdf5
}  // namespace gripline
