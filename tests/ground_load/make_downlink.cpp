// make-downlink FOLDER KEYFRAMES: what a long straight flight over a plane sends down, at 80 % overlap.

#include <cstdlib>
#include <exception>
#include <iostream>

#include "tests/unit/ground/synthetic_flight.hpp"

int main(int argc, char** argv) {
  using namespace ilp::test;
  if (argc != 3) {
    std::cerr << "usage: make-downlink FOLDER KEYFRAMES\n";
    return 2;
  }
  try {
    SyntheticFlight flight = make_flight(false);
    const SyntheticView pattern = flight.views[0];
    flight.camera = {640, 480, 600, 600, 319.5, 239.5, 0, 0, 0, 0};
    flight.views.clear();
    const double step = 0.2 * 10 * 640 / 600;  // 10 units above the plane
    for (int i = 0; i < std::atoi(argv[2]); ++i) {
      SyntheticView view = pattern;
      view.keyframe_id = i + 1;
      view.name = "frame-" + std::to_string(i) + ".png";
      view.centre.x() = step * i;
      view.centre.z() = plane_height(view.centre.x(), view.centre.y()) + 10;
      flight.views.push_back(view);
    }
    write_outbox(flight, argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "make-downlink: " << error.what() << "\n";
    return 1;
  }
}
