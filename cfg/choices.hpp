// The enumerations of mission parameters. A mission file gives a value by its name or its number; the link and stored
// settings use the number.
#pragma once

#include "fsw/base/enumeration.hpp"

namespace ilp {

ILP_ENUMERATION(CaptureMode, (0, regular, "at a constant interval"),
                (1, forecast, "when the forecast overlap reaches its target"),
                (2, telecommanded, "only when telecommanded"))

ILP_ENUMERATION(DownlinkOrder, (0, worth, "the products of most utility for their bytes"),
                (1, origin, "the oldest products"))

ILP_ENUMERATION(StereoMatcherChoice, (0, semi_global, "semi-global matching along five paths"),
                (1, ordered_scanline, "the cheapest ordered path through each scanline"))

/// What must be authenticated on the link (docs/links.md).
ILP_ENUMERATION(Authentication, (0, none, "nothing is"), (1, telecommands, "telecommands are"),
                (2, telecommands_and_files, "telecommands and CFDP PDUs are"))

/// The ground system whose widths of fields are used: the rows of tailorings().
ILP_ENUMERATION(GroundSystem, (0, standard, "the project's own"), (1, fsfw, "Flight Software Framework"),
                (2, yamcs, "Yamcs"))

/// The body whose ellipsoid relates longitude and latitude to metres.
ILP_ENUMERATION(Body, (0, none, "positions are not used"), (1, mars, ""), (2, titan, ""), (3, venus, ""), (4, moon, ""),
                (5, earth, ""))

namespace cfdp {

/// The supported checksum types of SANA's registry of CFDP checksum types.
ILP_ENUMERATION(ChecksumType, (0, modular, "sum of words of 4 octets, the first octet of a word the most significant"),
                (2, crc32c, "CRC-32C, the Castagnoli polynomial"), (3, crc32, "CRC-32, that of Ethernet"),
                (15, null, "no checksum: always 0"))

}  // namespace cfdp
}  // namespace ilp
