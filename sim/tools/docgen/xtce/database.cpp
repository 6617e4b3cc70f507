#include "sim/tools/docgen/xtce/database.hpp"

#include "cfg/version.hpp"
#include "sim/tools/docgen/xtce/parts.hpp"

namespace ilp::docgen {

std::string xtce_database(const MissionParameters& mission, bool flat) {
  XtceMission chosen;
  chosen.tailoring = tailoring_of(mission.tailoring, mission.cuc_time != 0, mission.agency_epoch_s);
  chosen.apid = static_cast<std::uint16_t>(mission.apid);
  chosen.flat = flat;
  SpaceSystem root("ILP", "image processing package of a planetary aerobot");
  add_telemetry(chosen, root);
  add_telecommands(chosen, root);
  root.children.push_back(housekeeping(chosen, root));
  root.children.push_back(events(chosen));
  root.children.push_back(parameters(chosen, root));
  if (flat) root.flatten();
  Xml header(1);
  header.open("Header", {{"version", software_version}, {"validationStatus", "Released"}});
  header.open("NoteSet");
  header.leaf("Note", {},
              std::string("Made by ilp-xtce from the rows of the flight software, for the tailoring ") +
                  chosen.tailoring.name + ".");
  header.close();
  header.close();
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" +
         root.text(0, {{"xmlns", "http://www.omg.org/spec/XTCE/20180204"}}, header.text());
}

}  // namespace ilp::docgen
