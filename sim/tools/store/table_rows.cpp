#include "sim/tools/store/table_rows.hpp"

#include <array>
#include <charconv>
#include <cstring>
#include <limits>
#include <ostream>
#include <stdexcept>

#include "fsw/records/records.hpp"
#include "hal/store/record_bytes.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::store_tool {
namespace {

const RecordInfo& table_named(const std::string& name) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    if (name == info.name) return info;
  }
  std::vector<std::string> names;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t)
    names.emplace_back(record_info(static_cast<RecordType>(t)).name);
  throw std::runtime_error("there is no table " + name + ": docs/records.md lists them" +
                           host::did_you_mean(name, names));
}

std::vector<const FieldInfo*> fields_named(const RecordInfo& info, const std::vector<std::string>& names) {
  std::vector<const FieldInfo*> fields;
  for (std::size_t f = 0; f < info.field_count && names.empty(); ++f) fields.push_back(&info.fields[f]);
  for (const std::string& name : names) {
    const FieldInfo* found = nullptr;
    for (std::size_t f = 0; f < info.field_count; ++f) {
      if (name == info.fields[f].name) found = &info.fields[f];
    }
    if (found == nullptr) {
      std::vector<std::string> known;
      for (std::size_t f = 0; f < info.field_count; ++f) known.emplace_back(info.fields[f].name);
      throw std::runtime_error("the table " + std::string(info.name) + " has no field " + name +
                               host::did_you_mean(name, known));
    }
    fields.push_back(found);
  }
  return fields;
}

template <typename Number>
std::string number_at(const std::uint8_t* at) {
  Number number{};
  std::memcpy(&number, at, sizeof(number));
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.begin(), text.end(), number).ptr};
}

std::string element_at(const FieldInfo& field, const std::uint8_t* at) {
  switch (field.type) {
    case FieldType::u8:
      if (const EnumValue* const named = find_value(field.values, *at)) return named->name;
      return number_at<std::uint8_t>(at);
    case FieldType::u16:
      return number_at<std::uint16_t>(at);
    case FieldType::i32:
      return number_at<std::int32_t>(at);
    case FieldType::i64:
      return number_at<std::int64_t>(at);
    case FieldType::f32:
      return number_at<float>(at);
    case FieldType::f64:
      return number_at<double>(at);
    default:
      return number_at<std::uint32_t>(at);
  }
}

// A text may hold anything: what is not printable ASCII is shown as `?`, so that a line stays a line.
std::string text_at(const FieldInfo& field, const std::uint8_t* at) {
  std::string text(reinterpret_cast<const char*>(at), field.count);
  text.resize(std::strlen(text.c_str()));
  for (char& c : text) c = c >= ' ' && c <= '~' ? c : '?';
  return text;
}

std::string value_of(const FieldInfo& field, const std::uint8_t* record) {
  const std::uint8_t* at = record + field.offset;
  if (field.type == FieldType::text) return text_at(field, at);
  std::string value;
  for (std::size_t i = 0; i < field.count; ++i) {
    value += (i == 0 ? "" : ",") + element_at(field, at + i * element_bytes(field.type));
  }
  return value;
}

}  // namespace

std::int64_t print_rows(Store& store, const std::string& table, const std::vector<std::string>& names,
                        std::ostream& out) {
  const RecordInfo& info = table_named(table);
  const std::vector<const FieldInfo*> fields = fields_named(info, names);
  const auto print_line = [&](auto text_of) {
    for (std::size_t f = 0; f < fields.size(); ++f) out << (f == 0 ? "" : "\t") << text_of(*fields[f]);
    out << '\n';
  };
  print_line([](const FieldInfo& field) { return field.name; });
  alignas(8) std::array<std::uint8_t, limits::max_record_bytes> record{};
  std::int64_t after = std::numeric_limits<std::int64_t>::min(), damaged = 0;
  while (true) {
    const Status status = store.next(info, after, record.data());
    if (status.is(StatusCode::not_found)) return damaged;
    if (!status.ok() && !status.is(StatusCode::record_damaged)) {
      throw std::runtime_error(std::string("table ") + info.name + ": " + status_name(status.code));
    }
    after = status.ok() ? id_of(record.data()) : status.a;
    if (status.ok()) {
      print_line([&](const FieldInfo& field) { return value_of(field, record.data()); });
    } else {
      ++damaged;
    }
  }
}

}  // namespace ilp::store_tool
