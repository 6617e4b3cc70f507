#include "bsp/flight/status_text.hpp"

#include <cstring>
#include <iterator>
#include <limits>

#include "bsp/flight/self_test.hpp"
#include "cfg/mission.hpp"
#include "cfg/relations.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/heap_gate.hpp"
#include "fsw/commanding/configuration.hpp"
#include "fsw/executive/work_level.hpp"
#include "fsw/packets/cfdp_pdu.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"
#include "hal/camera/v4l2/driver_grade.hpp"
#include "hal/compute/compute.hpp"

namespace ilp {
namespace {

// The regions of fsw/base/heap_gate.hpp, and SQLite's behind them.
constexpr EnumValue arena_values[] = {
    {0, "start", "of the start"}, {1, "openjpeg", ""}, {2, "postgres", ""}, {3, "jpeg", ""}, {4, "sqlite", ""}};
static_assert(static_cast<std::size_t>(HeapRegion::count) + 1 == std::size(arena_values));

constexpr struct {
  ValueType type;
  EnumValues values;
} enumerations[] = {
    {ValueType::argument, Argument_values},
    {ValueType::arena, arena_values},
    {ValueType::brightness, Brightness_values},
    {ValueType::calibration_verdict, CalibrationVerdict_values},
    {ValueType::codec_stage, CodecStage_values},
    {ValueType::compute_fault, ComputeFault_values},
    {ValueType::compute_kind, compute_kind_values},
    {ValueType::condition, cfdp::Condition_values},
    {ValueType::file_kind, DownlinkKind_values},
    {ValueType::flag, boolean_values},
    {ValueType::format, FormatFault_values},
    {ValueType::frame_damage, FrameDamage_values},
    {ValueType::intrinsic, Intrinsic_values},
    {ValueType::load_reason, LoadReason_values},
    {ValueType::memory_source, MemorySource_values},
    {ValueType::overlap_verdict, OverlapVerdict_values},
    {ValueType::pdu_fault, cfdp::PduFault_values},
    {ValueType::rectification_fault, RectificationFault_values},
    {ValueType::reduced_work, ReducedWork_values},
    {ValueType::relation, Relation_values},
    {ValueType::revert_reason, RevertReason_values},
    {ValueType::self_test, SelfTest_values},
    {ValueType::start_reason, StartReason_values},
    {ValueType::strip_end, StripEnd_values},
    {ValueType::strip_frame_verdict, StripFrameVerdict_values},
};

void add_fraction(std::int64_t value, std::int64_t per_unit, StatusText& text) {
  const std::int64_t whole = value / per_unit;
  std::int64_t rest = value % per_unit;
  if (value < 0 && whole == 0) text.add('-');
  text.add(whole);
  if (rest == 0) return;
  text.add('.');
  for (std::int64_t digit = per_unit / 10; rest != 0; digit /= 10) {
    text.add((rest < 0 ? -rest : rest) / digit);
    rest %= digit;
  }
}

void add_hexadecimal(std::int64_t value, StatusText& text) {
  text.add("0x");
  const auto bits = static_cast<std::uint64_t>(value);
  int shift = 60;
  while (shift > 0 && bits >> shift == 0) shift -= 4;
  for (; shift >= 0; shift -= 4) text.add("0123456789abcdef"[bits >> shift & 0xFU]);
}

void add_component(std::int64_t number, StatusText& text) {
  for (const Stage& stage : schedule) {
    if (static_cast<std::int64_t>(stage.component) == number) {
      text.add(stage.name);
      return;
    }
  }
  number == 0 ? text.add("package") : text.add(number);
}

/// The names of the bits that are set, between commas.
template <typename AddName>
void add_set(std::int64_t value, int count, const AddName& add_name, StatusText& text) {
  if (value == 0) text.add("none");
  if (value < 0 || value >> count != 0) {
    add_hexadecimal(value, text);
    return;
  }
  const char* between = "";
  for (int bit = 0; bit < count; ++bit) {
    if ((value >> bit & 1) == 0) continue;
    text.add(between);
    add_name(bit);
    between = ", ";
  }
}

void add_parameter(std::int64_t number, StatusText& text) {
  const std::size_t index = number < 0 ? parameter_count() : find_parameter(static_cast<std::uint64_t>(number));
  if (index < parameter_count()) {
    text.add(parameter_info(index).section).add('.').add(parameter_info(index).key);
  } else if (number == 0) {
    text.add("none");
  } else {
    text.add(number);
  }
}

void add_table(std::int64_t type, StatusText& text) {
  if (type >= 0 && type < static_cast<std::int64_t>(RecordType::count)) {
    text.add(record_info(static_cast<RecordType>(type)).name);
  } else {
    text.add(type);
  }
}

/// The four characters of a format of Linux, or the number.
void add_format(std::int64_t code, StatusText& text) {
  char characters[5] = {};
  bool printable = code >> 32 == 0;
  for (int i = 0; i < 4; ++i) {
    characters[i] = static_cast<char>(code >> (8 * i) & 0xFF);
    printable = printable && characters[i] >= ' ' && characters[i] <= '~';
  }
  printable ? text.add(characters) : text.add(code);
}

void add_error(std::int64_t number, StatusText& text) {
  text.add("errno ").add(number);
  const bool known = number > 0 && number <= std::numeric_limits<int>::max();
  if (known) text.add(", ").add(std::strerror(static_cast<int>(number)));
}

/// A number with the unit of its type, if it has one.
void add_number(ValueType type, std::int64_t value, StatusText& text) {
  const ValueTypeInfo& info = info_of(type);
  if (type == ValueType::thousandths && value == no_number) {
    text.add("no number");
    return;
  }
  add_fraction(value, info.per_unit, text);
  if (info.unit[0] != 0) text.add(' ').add(info.unit);
}

bool add_named(ValueType type, std::int64_t value, StatusText& text) {
  const EnumValues values = named_values(type);
  const EnumValue* const found = value < 0 ? nullptr : find_value(values, static_cast<std::uint64_t>(value));
  if (found == nullptr) return false;
  if (type == ValueType::argument) {
    for (const char* c = found->name; *c != 0; ++c) text.add(*c == '_' ? ' ' : *c);
    if (found->meaning[0] != 0) text.add(" (expected: ").add(found->meaning).add(')');
  } else {
    text.add(found->meaning[0] == 0 || type == ValueType::self_test ? found->name : found->meaning);
  }
  return true;
}

void add_value(ValueType type, std::int64_t value, StatusText& text) {
  if (add_named(type, value, text)) return;
  switch (type) {
    case ValueType::hexadecimal:
      return add_hexadecimal(value, text);
    case ValueType::size:
      add_number(ValueType::number, value / 100'000, text);
      text.add(" x ");
      return add_number(ValueType::pixels, value % 100'000, text);
    case ValueType::error:
      return add_error(value, text);
    case ValueType::component:
      return add_component(value, text);
    case ValueType::stages:
      return add_set(
          value, component_numbers, [&](int bit) { add_component(bit + 1, text); }, text);
    case ValueType::table:
      return add_table(value, text);
    case ValueType::parameter:
      return add_parameter(value, text);
    case ValueType::format:
      return add_format(value, text);
    case ValueType::findings:
      return add_set(
          value, finding::count, [&](int bit) { text.add(finding::texts[bit]); }, text);
    case ValueType::fault:
      if (value >= 0 && is_status_code(static_cast<std::uint64_t>(value))) {
        text.add(status_name(static_cast<StatusCode>(value)));
        return;
      }
      return add_number(type, value, text);
    default:
      return add_number(type, value, text);
  }
}

}  // namespace

EnumValues named_values(ValueType type) {
  for (const auto& enumeration : enumerations) {
    if (enumeration.type == type) return enumeration.values;
  }
  return {};
}

StatusText value_text(ValueType type, std::int64_t value) {
  StatusText text;
  add_value(type, value, text);
  return text;
}

StatusText status_words(const Status& status) {
  const StatusValues values = status_values(status.code);
  StatusText text;
  for (const char* c = status_text(status.code); *c != 0; ++c) {
    if (c[0] == '%' && (c[1] == 'a' || c[1] == 'b')) {
      ++c;
      *c == 'a' ? add_value(values.a.type, status.a, text) : add_value(values.b.type, status.b, text);
    } else {
      text.add(*c);
    }
  }
  return text;
}

}  // namespace ilp
