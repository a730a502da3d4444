// The tables of a results folder in one HDF5 file, for h5py, MATLAB, Julia and R.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gripline::tools {

/// Writes every CSV file at the top of `folder` as a group of its name (`table.csv` as `/table`), in it each column as
/// a dataset of one dimension: 64-bit floats where every cell is a number or empty (NaN), else UTF-8 text. A dataset is
/// named as its column, with "." for "/" and without a leading "/"; the attribute `column` has the name as it stands in
/// the CSV file, `unit` and `meaning` are those of `gripline columns` where it knows the column.
/// Returns the names of the groups. Throws InputError if the folder has no table, std::runtime_error naming `file` if
/// it cannot be written; then nothing is left of it.
std::vector<std::string> write_hdf5(const std::filesystem::path& folder, const std::filesystem::path& file);

}  // namespace gripline::tools
