// Helpers of the integration tests for programs and for the files of a flight.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/host/image_io.hpp"
#include "tests/support/store_records.hpp"

namespace ilp::test {

/// The folders that prepare_flights made: plain/, distorted/, rugged/, flat/ (images and truth) and uninterrupted/ (the
/// flight over plain/).
[[nodiscard]] std::filesystem::path prepared_flights();
/// The camera of such a flight without its distortion, as `ilp-onboard --camera` takes it.
[[nodiscard]] std::string camera_numbers(const std::filesystem::path& flight);

struct ProgramResult {
  int exit_status = -1;  ///< -1: did not end by itself
  std::string output;    ///< standard output and error
};
/// Waits for the program; `input` may be empty.
ProgramResult run_program(const std::vector<std::string>& arguments, const std::filesystem::path& input = {});
/// The test fails where the program does not end with status 0.
ProgramResult run_well(const std::vector<std::string>& arguments, const std::filesystem::path& input = {});
/// Kills the program after this many milliseconds (SIGKILL); true when it ended by itself before, with status 0.
bool run_and_kill(const std::vector<std::string>& arguments, int after_ms);

/// ilp-sil with the images and the camera of a prepared flight, and further arguments.
[[nodiscard]] std::vector<std::string> sil_command(const std::filesystem::path& flight,
                                                   const std::filesystem::path& out,
                                                   const std::vector<std::string>& more = {});

using Bytes = std::vector<std::uint8_t>;
[[nodiscard]] Bytes read_file(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, const std::string& text);
/// For its owner alone, as keys have to be.
void write_private_file(const std::filesystem::path& path, const std::string& text);
/// Files of the folder whose names begin with one of the prefixes.
[[nodiscard]] std::map<std::string, Bytes> files_of(const std::filesystem::path& folder,
                                                    const std::vector<std::string>& prefixes);
/// Products and records: what must be the same however often the power fails.
[[nodiscard]] std::map<std::string, Bytes> results_of(const std::filesystem::path& out);
/// The same names with the same bytes, or a test failure that says which differ.
void expect_same_files(const std::map<std::string, Bytes>& a, const std::map<std::string, Bytes>& b);

/// All records of one type in the database of a flight.
template <typename Record>
[[nodiscard]] std::vector<Record> records_of(const std::filesystem::path& out) {
  SqliteStore store;
  if (!store.open_read_only((out / "flight.db").c_str()).ok()) return {};
  return records_of<Record>(store);
}
[[nodiscard]] std::size_t events_of(const std::filesystem::path& out, StatusCode code);

/// A folder of images like a prepared flight's, to be spoilt: images/NNNN.pgm, index.txt, cameras.txt.
class OwnFlight {
 public:
  explicit OwnFlight(std::filesystem::path folder);
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] host::Raster<std::uint8_t> frame(int number) const;
  void replace(int number, const host::Raster<std::uint8_t>& image) const;
  /// Writes the index again with these frames only, at their times.
  void keep(const std::vector<int>& numbers) const;
  /// Writes the index again with frames in another order, one every 4 s: out, then elsewhere behind a gap, then over
  /// the first ground again.
  void come_back() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace ilp::test
