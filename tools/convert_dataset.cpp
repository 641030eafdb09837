// convert_dataset KIND SOURCE TARGET: other people's calibration data as one of our data-set folders, for
// `host calibrate --dataset TARGET`.
#include <iostream>

#include "protocol/config_error.hpp"
#include "tools/command_line.hpp"
#include "tools/convert/convert.hpp"

int main(int argc, char** argv) {
  armsight::tools::CommandLine line(
      "Writes a calibration set of others as a data-set folder (host/DATASET.md); every row, every number",
      "convert_dataset");
  std::string kind, source, target, csv;
  line.add("KIND", kind, "talos, rct, ur10e, camodocal or ethz").required();
  line.add("SOURCE", source, "folder the set came in").required();
  line.add("TARGET", target, "folder to write").required();
  line.add("--csv", csv, "talos: which of its files");
  if (const auto code = line.parse(argc, argv)) return *code;
  try {
    const int rows = !csv.empty() && kind == "talos" ? armsight::tools::convert_talos(source, csv, target)
                                                     : armsight::tools::convert(kind, source, target);
    std::cout << "convert_dataset: " << rows << " looks in, " << rows << " looks out: " << target << '\n';
    return 0;
  } catch (const armsight::ConfigError& error) {
    std::cerr << "convert_dataset: " << error.what() << '\n';
    return 2;
  } catch (const std::filesystem::filesystem_error& error) {
    std::cerr << "convert_dataset: " << error.what() << '\n';
    return 2;
  }
}
