// A recorded strip that lasts as long as an operation: the images of a prepared flight, to and fro.
#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "fsw/base/time.hpp"
#include "tests/integration/flight_files.hpp"

namespace ilp::test {

/// The index of a strip with a frame every 50 ms, which goes on by an image every half second, by turns with the next
/// one. No image comes twice in a row: a repetition is left out, and the next one would be too far from its time.
/// Empty when the prepared flight has too few images.
inline std::string operated_strip(int seconds) {
  const std::filesystem::path plain = prepared_flights() / "plain";
  std::ifstream index(plain / "index.txt");
  std::vector<std::string> images;
  std::string line, name;
  while (std::getline(index, line)) {
    std::istringstream words(line);
    TimeNs time = 0;
    if (words >> time >> name) images.push_back((plain / name).string());
  }
  if (images.size() <= 10) return {};
  const int turn = static_cast<int>(images.size()) - 2;
  std::ostringstream strip;
  for (int i = 0; i < 20 * seconds; ++i) {
    const int place = std::abs((i / 10 + turn) % (2 * turn) - turn);
    strip << i * 50 * ns_per_ms << " " << images[static_cast<std::size_t>(place + (i + i / 10) % 2)] << "\n";
  }
  return strip.str();
}

}  // namespace ilp::test
