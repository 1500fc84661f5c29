# Copyright Triaxis contributors.
# SPDX-License-Identifier: Apache-2.0
#
# Constraints of nexys4ddr_top on the Nexys 4 DDR (xc7a100tcsg324-1). Pins: fpga/nexys4ddr_pins.toml,
# against which a test checks this file.

# --- Configuration: bank 0 is supplied with 3.3 V -----------------------------------------------

set_property CFGBVS VCCO [current_design]
set_property CONFIG_VOLTAGE 3.3 [current_design]

# --- Clock: the board's oscillator, 100 MHz -----------------------------------------------------

set_property -dict {PACKAGE_PIN E3 IOSTANDARD LVCMOS33} [get_ports {clk_100mhz_i}]
create_clock -name clk_100mhz -period 10.000 -waveform {0.000 5.000} [get_ports clk_100mhz_i]

# --- Reset button, USB-UART ----------------------------------------------------------------------

set_property -dict {PACKAGE_PIN C12 IOSTANDARD LVCMOS33} [get_ports {cpu_reset_ni}]
set_property -dict {PACKAGE_PIN C4 IOSTANDARD LVCMOS33} [get_ports {uart_rx_i}]
set_property -dict {PACKAGE_PIN D4 IOSTANDARD LVCMOS33} [get_ports {uart_tx_o}]
# An idle line where the USB bridge has no power.
set_property PULLTYPE PULLUP [get_ports uart_rx_i]

# --- LEDs, displays ------------------------------------------------------------------------------

set_property -dict {PACKAGE_PIN H17 IOSTANDARD LVCMOS33} [get_ports {led_o[0]}]
set_property -dict {PACKAGE_PIN K15 IOSTANDARD LVCMOS33} [get_ports {led_o[1]}]
set_property -dict {PACKAGE_PIN J13 IOSTANDARD LVCMOS33} [get_ports {led_o[2]}]
set_property -dict {PACKAGE_PIN N14 IOSTANDARD LVCMOS33} [get_ports {led_o[3]}]
set_property -dict {PACKAGE_PIN R18 IOSTANDARD LVCMOS33} [get_ports {led_o[4]}]
set_property -dict {PACKAGE_PIN V17 IOSTANDARD LVCMOS33} [get_ports {led_o[5]}]
set_property -dict {PACKAGE_PIN U17 IOSTANDARD LVCMOS33} [get_ports {led_o[6]}]
set_property -dict {PACKAGE_PIN U16 IOSTANDARD LVCMOS33} [get_ports {led_o[7]}]
set_property -dict {PACKAGE_PIN V16 IOSTANDARD LVCMOS33} [get_ports {led_o[8]}]
set_property -dict {PACKAGE_PIN T15 IOSTANDARD LVCMOS33} [get_ports {led_o[9]}]
set_property -dict {PACKAGE_PIN U14 IOSTANDARD LVCMOS33} [get_ports {led_o[10]}]
set_property -dict {PACKAGE_PIN T16 IOSTANDARD LVCMOS33} [get_ports {led_o[11]}]
set_property -dict {PACKAGE_PIN V15 IOSTANDARD LVCMOS33} [get_ports {led_o[12]}]
set_property -dict {PACKAGE_PIN V14 IOSTANDARD LVCMOS33} [get_ports {led_o[13]}]
set_property -dict {PACKAGE_PIN V12 IOSTANDARD LVCMOS33} [get_ports {led_o[14]}]
set_property -dict {PACKAGE_PIN V11 IOSTANDARD LVCMOS33} [get_ports {led_o[15]}]
set_property -dict {PACKAGE_PIN T10 IOSTANDARD LVCMOS33} [get_ports {seg_no[0]}]
set_property -dict {PACKAGE_PIN R10 IOSTANDARD LVCMOS33} [get_ports {seg_no[1]}]
set_property -dict {PACKAGE_PIN K16 IOSTANDARD LVCMOS33} [get_ports {seg_no[2]}]
set_property -dict {PACKAGE_PIN K13 IOSTANDARD LVCMOS33} [get_ports {seg_no[3]}]
set_property -dict {PACKAGE_PIN P15 IOSTANDARD LVCMOS33} [get_ports {seg_no[4]}]
set_property -dict {PACKAGE_PIN T11 IOSTANDARD LVCMOS33} [get_ports {seg_no[5]}]
set_property -dict {PACKAGE_PIN L18 IOSTANDARD LVCMOS33} [get_ports {seg_no[6]}]
set_property -dict {PACKAGE_PIN H15 IOSTANDARD LVCMOS33} [get_ports {seg_no[7]}]
set_property -dict {PACKAGE_PIN J17 IOSTANDARD LVCMOS33} [get_ports {an_no[0]}]
set_property -dict {PACKAGE_PIN J18 IOSTANDARD LVCMOS33} [get_ports {an_no[1]}]
set_property -dict {PACKAGE_PIN T9 IOSTANDARD LVCMOS33} [get_ports {an_no[2]}]
set_property -dict {PACKAGE_PIN J14 IOSTANDARD LVCMOS33} [get_ports {an_no[3]}]
set_property -dict {PACKAGE_PIN P14 IOSTANDARD LVCMOS33} [get_ports {an_no[4]}]
set_property -dict {PACKAGE_PIN T14 IOSTANDARD LVCMOS33} [get_ports {an_no[5]}]
set_property -dict {PACKAGE_PIN K2 IOSTANDARD LVCMOS33} [get_ports {an_no[6]}]
set_property -dict {PACKAGE_PIN U13 IOSTANDARD LVCMOS33} [get_ports {an_no[7]}]

# --- Collision output: Pmod JA, pin 1 go, 2 stop, 3 beat, 4 and 7 beyond slow and warn --------------
#
# Go is go high together with stop low; anything else means stop. The resistors in the FPGA hold both
# pins at stop while a configured device does not drive them. They do nothing before configuration: an
# FPGA without a design may pull up all of its pins, weakly (UG470, PUDC_B; DS181, I_RPU), or none. So
# the receiver must say stop by itself. It needs, at its end of the cable:
#   - a resistor from go to ground and one from stop to its own supply, both strong enough against the
#     FPGA's weak pull-ups (1 kilohm): an open wire, a cable that is cut or not plugged, and a board
#     without power or design are then all stop;
#   - to look at both wires: a short between them, or of one of them to a supply, is then stop too, and
#     both alike for longer than a change takes is a fault to be reported;
#   - where the board's oscillator may fail: a retriggerable monostable on beat, of some milliseconds,
#     without which go does not count.
# Beyond a zone is high together with go; a wire that is open is low, which is inside it.

set_property -dict {PACKAGE_PIN C17 IOSTANDARD LVCMOS33} [get_ports {go_o}]
set_property -dict {PACKAGE_PIN D18 IOSTANDARD LVCMOS33} [get_ports {stop_o}]
set_property -dict {PACKAGE_PIN E18 IOSTANDARD LVCMOS33} [get_ports {beat_o}]
set_property -dict {PACKAGE_PIN G17 IOSTANDARD LVCMOS33} [get_ports {beyond_slow_o}]
set_property -dict {PACKAGE_PIN D17 IOSTANDARD LVCMOS33} [get_ports {beyond_warn_o}]
set_property PULLTYPE PULLDOWN [get_ports go_o]
set_property PULLTYPE PULLUP [get_ports stop_o]
set_property PULLTYPE PULLDOWN [get_ports beat_o]
set_property PULLTYPE PULLDOWN [get_ports beyond_slow_o]
set_property PULLTYPE PULLDOWN [get_ports beyond_warn_o]

# --- Asynchronous pins ---------------------------------------------------------------------------
#
# No clock outside relates to these. The button and the serial line go through synchronisers; a UART
# samples in the middle of bits of 25 / 3 clocks, 83 ns; people look at LEDs and displays; and who reads go
# and stop waits until they differ: a skew of some nanoseconds does not matter to any of them.

set_false_path -from [get_ports {cpu_reset_ni uart_rx_i}]
set_false_path -to [get_ports {uart_tx_o led_o[*] seg_no[*] an_no[*] go_o stop_o beat_o}]
set_false_path -to [get_ports {beyond_slow_o beyond_warn_o}]
