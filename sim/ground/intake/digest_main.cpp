// ilp-digest: one line per keyframe, to compare whether two flights computed the same.

#include <iostream>

#include "sim/ground/intake/flight_digest.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: ilp-digest DATABASE\n";
    return 2;
  }
  try {
    for (const std::string& line : ilp::intake::flight_digest(argv[1])) std::cout << line << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-digest: " << error.what() << "\n";
    return 1;
  }
}
