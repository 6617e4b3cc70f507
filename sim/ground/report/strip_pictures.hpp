// The pictures of a strip as figures of the page: PNG inside SVG with the track drawn over it.
#pragma once

#include <string>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

struct StripFigures {
  std::string ortho, relief, oblique;  ///< <figure> elements; empty without a grid
};
[[nodiscard]] StripFigures strip_figures(const intake::Flight& flight, const StripResult& strip);

}  // namespace ilp::report
