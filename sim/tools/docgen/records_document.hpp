// Generates the interface control document of the records in store and telemetry.
#pragma once

#include <string>

#include "fsw/records/field.hpp"

namespace ilp::docgen {

/// The type's name in the documents: u8, f64, ...
[[nodiscard]] const char* field_type_name(FieldType type);

/// A list item with name, type, number of elements, unit and meaning: "- `centre_m` f64[3] m: meaning".
[[nodiscard]] std::string field_item(const FieldInfo& field);

/// Body of records.md, below its title.
std::string records_document();

}  // namespace ilp::docgen
