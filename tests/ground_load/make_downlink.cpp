// make-downlink FOLDER KEYFRAMES [LEGS [WIDTH HEIGHT]]: what a long flight over a plane sends down, at 80 % overlap
// along the track: straight, or back and forth in parallel legs whose images overlap by 20 %, so that the map stays
// small.

#include <cstdlib>
#include <exception>
#include <iostream>

#include "tests/unit/ground/synthetic_flight.hpp"

namespace {
using namespace ilp::test;

constexpr double height = 10;  // above the plane

SyntheticFlight survey(int keyframes, int legs, int width, int rows) {
  SyntheticFlight flight = make_flight(false);
  const SyntheticView pattern = flight.views[0];
  const double focal = 600.0 / 640 * width;
  flight.camera = {width, rows, focal, focal, (width - 1) / 2.0, (rows - 1) / 2.0, 0, 0, 0, 0};
  flight.views.clear();
  const double step = 0.2 * height * width / focal, side_step = 0.8 * height * rows / focal;
  const int of_a_leg = (keyframes + legs - 1) / legs;
  for (int i = 0; i < keyframes; ++i) {
    const int leg = i / of_a_leg, along = i % of_a_leg;
    SyntheticView view = pattern;
    view.keyframe_id = i + 1;
    view.name = "frame-" + std::to_string(i) + ".png";
    view.centre.x() = step * (leg % 2 == 0 ? along : of_a_leg - 1 - along);
    view.centre.y() = side_step * leg;
    view.centre.z() = plane_height(view.centre.x(), view.centre.y()) + height;
    flight.views.push_back(view);
  }
  return flight;
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int at, int otherwise) { return argc > at ? std::atoi(argv[at]) : otherwise; };
  const int keyframes = number(2, 0), legs = number(3, 1), width = number(4, 640), rows = number(5, 480);
  if (keyframes < 1 || legs < 1 || legs > keyframes || width < 32 || rows < 32 || argc == 5 || argc > 6) {
    std::cerr << "usage: make-downlink FOLDER KEYFRAMES [LEGS [WIDTH HEIGHT]]\n";
    return 2;
  }
  try {
    write_outbox(survey(keyframes, legs, width, rows), argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "make-downlink: " << error.what() << "\n";
    return 1;
  }
}
