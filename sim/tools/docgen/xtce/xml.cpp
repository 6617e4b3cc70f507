#include "sim/tools/docgen/xtce/xml.hpp"

#include "sim/host/text_format.hpp"

namespace ilp::docgen {
void Xml::begin(const std::string& name, const Attributes& attributes) {
  text_ += std::string(depth_ + open_.size(), ' ') + "<" + name;
  for (const auto& [key, value] : attributes) {
    if (!value.empty()) text_ += std::string(" ") + key + "=\"" + host::escaped(value) + "\"";
  }
}

void Xml::open(const std::string& name, const Attributes& attributes) {
  begin(name, attributes);
  text_ += ">\n";
  open_.push_back(name);
}

void Xml::close() {
  const std::string name = open_.back();
  open_.pop_back();
  text_ += std::string(depth_ + open_.size(), ' ') + "</" + name + ">\n";
}

void Xml::leaf(const std::string& name, const Attributes& attributes, const std::string& text) {
  begin(name, attributes);
  text_ += text.empty() ? "/>\n" : ">" + host::escaped(text) + "</" + name + ">\n";
}

}  // namespace ilp::docgen
