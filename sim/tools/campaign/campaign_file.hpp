// A campaign file: which flights to fly with which parameters, and what to show of them.
//   [campaign]  name, about, frames, timeout_s (of one flight and its score), jobs (in parallel), columns = KEY | KEY
//   [grid]      KEY = VALUE | VALUE ...; KEY is scenario, seed, frames or section.name; whole numbers also as 1..3
//   [group G]   another grid, beside [grid]
//   [set]       KEY = VALUE for every flight; the axis of a grid goes before it
//   [plot P]    x (an axis of a grid or a number of the score), y (a number of the score), series = AXIS | AXIS, log_x
//   and
//               log_y = true | false
// Paths among the values are relative to the campaign file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::batch {

struct Setting {
  std::string key, value;
  int line = 0;
};

struct Axis {
  std::string key;
  std::vector<std::string> values;
  int line = 0;
};

struct Grid {
  std::string name;  ///< empty for [grid]
  std::vector<Axis> axes;
};

struct PlotRequest {
  std::string name, x, y;
  std::vector<std::string> series;
  bool log_x = false, log_y = false;
  int line = 0;
};

struct Campaign {
  std::filesystem::path file;
  std::string name;  ///< default: the file's
  std::string about;
  int frames = 0;  ///< 0: the simulator's own number
  double timeout_s = 900;
  int jobs = 0;  ///< 0: one for each core
  std::vector<std::string> columns;
  std::vector<Grid> grids;
  std::vector<Setting> settings;
  std::vector<PlotRequest> plots;
};

/// std::runtime_error "FILE:LINE: what is wrong, what was expected".
[[nodiscard]] Campaign read_campaign(const std::filesystem::path& file);

/// True for a name that is a file's: with a slash or the extension .ini.
[[nodiscard]] bool is_scenario_file(const std::string& scenario);

}  // namespace ilp::batch
