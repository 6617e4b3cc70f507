// The interface control document of the packet link: what ground software has to know to command the package.
#pragma once

#include <string>

namespace ilp::docgen {

/// Body of interface-control-document.md, below its title.
std::string interface_document();

}  // namespace ilp::docgen
