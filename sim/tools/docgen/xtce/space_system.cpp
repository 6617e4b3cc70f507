#include "sim/tools/docgen/xtce/space_system.hpp"

#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace ilp::docgen {
namespace {

std::string decimal(std::size_t value) {
  return std::to_string(value);
}

/// IntegerParameterType, IntegerArgumentType.
std::string element(const char* kind, Side side) {
  return std::string(kind) + (side == Side::parameter ? "ParameterType" : "ArgumentType");
}

void encoding(const NumberForm& form, Xml& xml) {
  const char* const name = form.is_float ? "FloatDataEncoding" : "IntegerDataEncoding";
  const std::string kind = form.is_float ? "IEEE754_1985" : form.is_signed ? "twosComplement" : "unsigned";
  const Xml::Attributes attributes = {{"encoding", kind}, {"sizeInBits", decimal(form.bits)}};
  if (form.scale == 1) {
    xml.leaf(name, attributes);
    return;
  }
  xml.open(name, attributes);
  xml.open("DefaultCalibrator");
  xml.open("PolynomialCalibrator");
  xml.leaf("Term", {{"coefficient", xtce_number(form.scale)}, {"exponent", "1"}});
  xml.close();
  xml.close();
  xml.close();
}

void range(Side side, const NumberForm& form, Xml& xml) {
  if (!form.min && !form.max) return;
  const auto limit = [&](const std::optional<double>& value) { return value ? xtce_number(*value) : ""; };
  const Xml::Attributes attributes = {{"minInclusive", limit(form.min)}, {"maxInclusive", limit(form.max)}};
  if (side == Side::argument) xml.open("ValidRangeSet");
  xml.leaf("ValidRange", attributes);
  if (side == Side::argument) xml.close();
}

}  // namespace

std::vector<Choice> choices_of(EnumValues values) {
  std::vector<Choice> choices;
  for (const EnumValue& value : values) choices.push_back({value.number, value.name, value.meaning});
  return choices;
}

std::string xtce_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (c == '/') {
      name += "_per_";
    } else {
      name += plain ? c : '_';
    }
  }
  return name;
}

std::string xtce_number(double value) {
  std::array<char, 40> text{};
  for (const int digits : {15, 17}) {
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    if (std::strtod(text.data(), nullptr) == value) break;
  }
  // Whole numbers without an exponent: they may stand where the schema wants an integer.
  if (value == std::floor(value) && std::fabs(value) < 1e15) std::snprintf(text.data(), text.size(), "%.0f", value);
  return text.data();
}

bool SpaceSystem::first(Side side, const std::string& name) {
  return (side == Side::parameter ? parameter_type_names_ : argument_type_names_).insert(name).second;
}

std::string SpaceSystem::number_type(Side side, const std::string& own_name, const NumberForm& form) {
  const std::string name = named(own_name);
  if (!first(side, name)) return name;
  Xml& xml = types(side);
  const bool is_float = form.is_float || form.scale != 1;
  // A calibrated value needs all the digits of its number.
  const std::size_t bits = is_float && form.scale != 1 ? 64 : form.bits;
  const std::string kind = element(is_float ? "Float" : "Integer", side);
  xml.open(kind, {{"name", name},
                  {"sizeInBits", decimal(bits)},
                  {"signed", is_float         ? ""
                             : form.is_signed ? "true"
                                              : "false"}});
  if (!form.unit.empty()) {
    xml.open("UnitSet");
    xml.leaf("Unit", {}, form.unit);
    xml.close();
  }
  encoding(form, xml);
  range(side, form, xml);
  xml.close();
  return name;
}

std::string SpaceSystem::number_type(Side side, const NumberForm& form) {
  std::string name = (form.is_float ? "f" : form.is_signed ? "i" : "u") + decimal(form.bits);
  if (!form.unit.empty()) name += "_" + xtce_name(form.unit);
  return number_type(side, name, form);
}

std::string SpaceSystem::choice_type(Side side, const std::string& own_name, std::size_t bits,
                                     const std::vector<Choice>& choices) {
  const std::string name = named(own_name);
  if (!first(side, name)) return name;
  Xml& xml = types(side);
  xml.open(element("Enumerated", side), {{"name", name}});
  encoding({.bits = bits}, xml);
  xml.open("EnumerationList");
  for (const Choice& choice : choices) {
    xml.leaf("Enumeration",
             {{"value", std::to_string(choice.number)}, {"label", choice.label}, {"shortDescription", choice.meaning}});
  }
  xml.close();
  xml.close();
  return name;
}

std::string SpaceSystem::time_type(Side side, const std::string& own_name, std::size_t bits, double scale,
                                   double offset, const std::string& offset_from, const std::string& epoch) {
  const std::string name = named(own_name);
  if (!first(side, name)) return name;
  Xml& xml = types(side);
  xml.open(element("AbsoluteTime", side), {{"name", name}});
  xml.open("Encoding", {{"units", "seconds"},
                        {"scale", scale == 1 ? "" : xtce_number(scale)},
                        {"offset", offset == 0 ? "" : xtce_number(offset)}});
  encoding({.bits = bits}, xml);
  xml.close();
  xml.open("ReferenceTime");
  if (offset_from.empty()) {
    xml.leaf("Epoch", {}, epoch);
  } else {
    xml.leaf("OffsetFrom", {{"parameterRef", offset_from}});
  }
  xml.close();
  xml.close();
  return name;
}

std::string SpaceSystem::bytes_type(Side side, const std::string& own_name, std::size_t bytes) {
  const std::string name = named(own_name);
  if (!first(side, name)) return name;
  Xml& xml = types(side);
  xml.open(element("Binary", side), {{"name", name}});
  xml.open("BinaryDataEncoding");
  xml.open("SizeInBits");
  xml.leaf("FixedValue", {}, decimal(8 * bytes));
  xml.close();
  xml.close();
  xml.close();
  return name;
}

std::string SpaceSystem::sized_type(Side side, const char* kind, const std::string& own_name,
                                    const std::string& counted, std::int64_t slope, std::int64_t intercept) {
  const std::string name = named(own_name);
  if (!first(side, name)) return name;
  Xml& xml = types(side);
  const bool text = std::string(kind) == "String";
  xml.open(element(kind, side), {{"name", name}});
  xml.open(text ? "StringDataEncoding" : "BinaryDataEncoding", {{"encoding", text ? "UTF-8" : ""}});
  xml.open(text ? "Variable" : "SizeInBits", {{"maxSizeInBits", text ? decimal(8 * 65536) : ""}});
  xml.open("DynamicValue");
  if (side == Side::parameter) {
    xml.leaf("ParameterInstanceRef", {{"parameterRef", counted}});
  } else {
    xml.leaf("ArgumentInstanceRef", {{"argumentRef", counted}});
  }
  xml.leaf("LinearAdjustment", {{"slope", std::to_string(slope)}, {"intercept", std::to_string(intercept)}});
  xml.close();
  xml.close();
  xml.close();
  xml.close();
  return name;
}

std::string SpaceSystem::parameter(const std::string& own_name, const std::string& type,
                                   const std::string& description) {
  std::string name = named(own_name);
  const auto [known, fresh] = parameter_names_.emplace(name, type);
  if (!fresh && known->second != type) throw std::runtime_error("the parameter " + name + " has two types");
  if (fresh)
    parameters_.leaf("Parameter", {{"name", name}, {"parameterTypeRef", type}, {"shortDescription", description}});
  return name;
}

void SpaceSystem::flatten() {
  for (SpaceSystem& child : children) take(child);
  children.clear();
}

void SpaceSystem::take(SpaceSystem& descendant) {
  for (SpaceSystem& child : descendant.children) take(child);
  parameter_type_names_.merge(descendant.parameter_type_names_);
  argument_type_names_.merge(descendant.argument_type_names_);
  parameter_names_.merge(descendant.parameter_names_);
  // What has not moved was known.
  if (!descendant.parameter_type_names_.empty() || !descendant.argument_type_names_.empty() ||
      !descendant.parameter_names_.empty()) {
    throw std::runtime_error("a name of " + descendant.name_ + " is defined twice");
  }
  parameter_types_.append(descendant.parameter_types_.text());
  argument_types_.append(descendant.argument_types_.text());
  parameters_.append(descendant.parameters_.text());
  containers.append(descendant.containers.text());
  commands.append(descendant.commands.text());
}

std::string SpaceSystem::text(std::size_t depth, const Xml::Attributes& attributes, const std::string& header) const {
  Xml xml(depth);
  Xml::Attributes all = {{"name", name_}, {"shortDescription", description_}};
  all.insert(all.end(), attributes.begin(), attributes.end());
  const auto set = [&](const char* name, const Xml& content) {
    if (content.empty()) return;
    xml.open(name);
    xml.append(content.text());
    xml.close();
  };
  xml.open("SpaceSystem", all);
  xml.append(header);
  if (!parameter_types_.empty() || !parameters_.empty() || !containers.empty()) {
    xml.open("TelemetryMetaData");
    set("ParameterTypeSet", parameter_types_);
    set("ParameterSet", parameters_);
    set("ContainerSet", containers);
    xml.close();
  }
  if (!commands.empty()) {
    xml.open("CommandMetaData");
    set("ArgumentTypeSet", argument_types_);
    set("MetaCommandSet", commands);
    xml.close();
  }
  for (const SpaceSystem& child : children) xml.append(child.text(depth + 1, {}, ""));
  xml.close();
  return xml.text();
}

}  // namespace ilp::docgen
