// ilp-ground serve: the live flight in a browser.
#pragma once

namespace ilp::serve {

/// The command line begins after the program's name. Runs until it is ended.
int serve_main(int argc, char** argv);

}  // namespace ilp::serve
