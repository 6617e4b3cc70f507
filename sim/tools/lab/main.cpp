// ilp-lab: runs single onboard kernels on files.

#include <iostream>

#include "sim/tools/lab/lab.hpp"

int main(int argc, char** argv) {
  return ilp::lab::run_lab(argc, argv, std::cout, std::cerr);
}
