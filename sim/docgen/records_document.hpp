// The interface control document of the records: store and telemetry.
#pragma once

#include <string>

namespace ilp::sim {

/// Body of records.md, below its title.
std::string records_document();

}  // namespace ilp::sim
