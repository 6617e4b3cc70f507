#include "fsw/commanding/settings.hpp"

#include "fsw/base/text.hpp"
#include "fsw/shared/find.hpp"

namespace ilp {
namespace {

FixedText<sizeof(SettingRecord::name)> full_name(const ParameterInfo& info) {
  FixedText<sizeof(SettingRecord::name)> name;
  name.add(info.section).add('.').add(info.key);
  return name;
}

}  // namespace

Status load_settings(Reader<SettingRecord> store, MissionParameters& mission) {
  MissionParameters wanted = mission;
  Status ignored;
  SettingRecord setting;
  for (;;) {  // bound: the settings; each turn reads a later one
    ILP_TAKE(const Found found, find_next(store, setting.id, setting));
    if (found == Found::nothing) break;
    const bool set = found == Found::valid &&
                     set_parameter(wanted, find_parameter(static_cast<std::uint64_t>(setting.id)), setting.value).ok();
    if (!set && (ignored.ok() || found == Found::damaged)) ignored = {StatusCode::setting_ignored, setting.id};
  }
  const Status valid = validate(wanted);
  if (!valid.ok()) return {StatusCode::setting_ignored, 0, valid.a};
  mission = wanted;
  return ignored;
}

Status write_setting(StorePart<Writes<SettingRecord>> store, std::size_t index, double value, TimeNs now) {
  SettingRecord setting;
  setting.id = parameter_info(index).number;
  copy_text(setting.name, full_name(parameter_info(index)).c_str());
  setting.value = value;
  setting.set_ns = now;
  return put(store, setting);
}

}  // namespace ilp
