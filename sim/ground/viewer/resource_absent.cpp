#include "sim/ground/viewer/resource.hpp"

namespace ilp::viewer {

std::string_view script() {
  return {};
}
std::string_view style() {
  return {};
}
std::string_view licence() {
  return {};
}

}  // namespace ilp::viewer
