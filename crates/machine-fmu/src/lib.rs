//! Shared library that hosts load for a described machine: the functions of FMI 2.0 and 3.0. One
//! library serves all machines. The packager puts it into an archive under the machine's name,
//! together with the machine's file; see `vibro_machine_component`.

use vibro_machine_component::Machine;

fmi_doors::export!(Machine);
