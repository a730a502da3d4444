#include "hdf5/hdf5_tables.hpp"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "experiment/column_docs.hpp"
#include "report/columns.hpp"

namespace gripline::tools {
namespace {

namespace fs = std::filesystem;

// Rows of a chunk: 256 KiB of numbers, so that a part of a table of 1e5 runs is read without the rest.
constexpr hsize_t chunk_rows = 32768;
constexpr unsigned compression = 4;  // of 9: later levels cost time and gain little on printed numbers

/// An identifier of the HDF5 library, closed at the end of its scope.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Id(hid_t id, Close close, const std::string& what) : id_(id), close_(close) {
    if (id < 0) throw std::runtime_error("HDF5: " + what);
  }
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  ~Hdf5Id() { close_(id_); }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  Close close_;
};

void check(herr_t status, const std::string& what) {
  if (status < 0) throw std::runtime_error("HDF5: " + what);
}

Hdf5Id text_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose, "no type of text"};
}

void write_attribute(hid_t object, const char* name, const std::string& value) {
  const Hdf5Id type = text_type();
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose, name);
  const Hdf5Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, name);
  const char* text = value.c_str();
  check(H5Awrite(attribute, type, &text), name);
}

std::string dataset_name(std::string column) {
  if (column.starts_with('/')) column.erase(0, 1);
  std::replace(column.begin(), column.end(), '/', '.');
  return column.empty() ? "_" : column;
}

/// The documentation of a column in that file, or null.
const ColumnDoc* find_doc(const std::string& file, const std::string& column) {
  const std::string name = documented_name(column);
  for (const ColumnDoc* doc : columns_of(file))
    if (name == doc->name) return doc;
  return nullptr;
}

bool is_missing(std::string cell) {
  cell = lower_case(std::move(cell));
  return cell.empty() || cell == "nan" || cell == "-nan";
}

bool is_numeric(const report::Columns& table, const std::string& column) {
  const std::span<const double> numbers = table.numbers(column);
  for (std::size_t row = 0; row < numbers.size(); ++row)
    if (std::isnan(numbers[row]) && !is_missing(table.text(column, row))) return false;
  return true;
}

void write_cells(const report::Columns& table, const std::string& column, bool numeric, hid_t dataset) {
  if (numeric) {
    check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, table.numbers(column).data()), column);
    return;
  }
  std::vector<std::string> texts(table.rows());
  std::vector<const char*> cells(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    texts[row] = table.text(column, row);
    cells[row] = texts[row].c_str();
  }
  const Hdf5Id type = text_type();
  check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, cells.data()), column);
}

void write_column(const report::Columns& table, const std::string& file, const std::string& column, hid_t group) {
  const std::array<hsize_t, 1> size = {table.rows()};
  const Hdf5Id space(H5Screate_simple(1, size.data(), nullptr), H5Sclose, column);
  const Hdf5Id layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, column);
  if (table.rows() >= 1024) {
    const std::array<hsize_t, 1> chunk = {std::min<hsize_t>(table.rows(), chunk_rows)};
    check(H5Pset_chunk(layout, 1, chunk.data()), column);
    if (H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0) check(H5Pset_deflate(layout, compression), column);
  }
  const bool numeric = is_numeric(table, column);
  const Hdf5Id text = text_type();
  const hid_t type = numeric ? H5T_IEEE_F64LE : static_cast<hid_t>(text);
  const std::string name = dataset_name(column);
  const Hdf5Id dataset(H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose,
                       file + ", column \"" + column + "\": there is already a dataset \"" + name + "\"");
  if (table.rows() > 0) write_cells(table, column, numeric, dataset);
  write_attribute(dataset, "column", column);
  if (const ColumnDoc* doc = find_doc(file, column)) {
    write_attribute(dataset, "unit", doc->unit);
    write_attribute(dataset, "meaning", doc->meaning);
  }
}

std::vector<fs::path> tables_of(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failed))
    if (entry.is_regular_file(failed) && entry.path().extension() == ".csv") files.push_back(entry.path());
  if (files.empty())
    throw InputError(folder.string() +
                     ": no table; expected a folder that compare or sweep wrote, with a table.csv in it");
  std::sort(files.begin(), files.end());
  return files;
}

void write_tables(const std::vector<fs::path>& files, const fs::path& out) {
  const Hdf5Id file(H5Fcreate(out.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, "cannot create it");
  for (const fs::path& csv : files) {
    const report::Columns table = report::Columns::read(csv, true);
    const std::string name = csv.stem().string();
    const Hdf5Id group(H5Gcreate2(file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name);
    for (const std::string& column : table.names()) write_column(table, csv.filename().string(), column, group);
  }
  check(H5Fflush(file, H5F_SCOPE_GLOBAL), "cannot write it to the disk");
}

}  // namespace

std::vector<std::string> write_hdf5(const fs::path& folder, const fs::path& file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are thrown, not printed
  const std::vector<fs::path> files = tables_of(folder);
  const fs::path partial = file.string() + ".partial";
  try {
    write_tables(files, partial);
    fs::rename(partial, file);
  } catch (const std::exception& failure) {
    std::error_code ignored;
    fs::remove(partial, ignored);
    throw std::runtime_error(file.string() + ": " + failure.what());
  }
  std::vector<std::string> groups;
  groups.reserve(files.size());
  for (const fs::path& csv : files) groups.push_back(csv.stem().string());
  return groups;
}

}  // namespace gripline::tools
