// The interface control document of the records: store and telemetry.
#pragma once

#include <string>

#include "fsw/records/field.hpp"

namespace ilp::docgen {

/// The type's name in the documents: u8, f64, ...
[[nodiscard]] const char* field_type_name(FieldType type);

/// "- `centre_m` f64[3] m: meaning": name, type, number of elements, unit and meaning as an item of a list.
[[nodiscard]] std::string field_item(const FieldInfo& field);

/// Body of records.md, below its title.
std::string records_document();

}  // namespace ilp::docgen
