// Generates the interface control document of the packet link, which authors of ground software need.
#pragma once

#include <string>

namespace ilp::docgen {

/// Body of interface-control-document.md, below its title.
std::string interface_document();

}  // namespace ilp::docgen
