// convert_dataset KIND SOURCE TARGET: other people's calibration data as one of our data-set folders, for
// `host calibrate --dataset TARGET`.
#include <iostream>

#include "host/parse_flags.hpp"
#include "protocol/config_error.hpp"
#include "tools/convert/convert.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Writes a calibration set of others as a data-set folder (host/DATASET.md); every row, every number"};
  std::string kind, source, target, csv;
  app.add_option("KIND", kind, "talos, rct, ur10e, camodocal or ethz")->required();
  app.add_option("SOURCE", source, "folder the set came in")->required();
  app.add_option("TARGET", target, "folder to write")->required();
  app.add_option("--csv", csv, "talos: which of its files");
  if (const auto code = armsight::host::parse_flags(app, argc, argv)) return *code;
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
