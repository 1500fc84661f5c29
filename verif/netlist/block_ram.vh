// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What RAMB18E1 and RAMB36E1 do (AMD, UG473) where one port writes and the other reads, old words first, as
// yosys uses them here: the inside of a module with their ports and parameters. In mode SDP port A reads and
// port B writes words of both ports' pins; in mode TDP port A writes and port B reads words of its own.
// Of nine bits the highest is parity. Any other use ends the simulation before it begins.

  localparam integer Bits = $bits(DOADO);
  // Nine bits each, in the memory and in a word.
  localparam integer Bytes = 128 * Bits;
  localparam integer Wide = 2 * Bits / 8;
  localparam integer Narrow = Bits / 8;
  typedef logic [$clog2(Bytes)-1:0] place_t;

  initial begin
    if (!(RAM_MODE == "SDP" && READ_WIDTH_A == 9 * Wide && WRITE_WIDTH_B == 9 * Wide) &&
        !(RAM_MODE == "TDP" && WRITE_WIDTH_A == 9 * Narrow && READ_WIDTH_B == 9 * Narrow &&
          READ_WIDTH_A == 0 && WRITE_WIDTH_B == 0) ||
        WRITE_MODE_A != "READ_FIRST" || WRITE_MODE_B != "READ_FIRST" || DOA_REG != 0 || DOB_REG != 0)
      $fatal(1, "block RAM: used in a way that its model does not know");
  end

  reg [8:0] memory[0:Bytes-1];

  generate
    if (RAM_MODE == "SDP") begin : g_wide
      wire [8*Wide-1:0] data = {DIBDI, DIADI};
      wire [Wide-1:0] parity = {DIPBDIP, DIPADIP};
      wire place_t reading = place_t'(ADDRARDADDR >> 3) & ~place_t'(Wide - 1);
      wire place_t writing = place_t'(ADDRBWRADDR >> 3) & ~place_t'(Wide - 1);
      reg [8*Wide-1:0] data_q;
      reg [Wide-1:0] parity_q;
      always @(posedge CLKARDCLK)
        if (ENARDEN)
          for (int n = 0; n < Wide; n++) {parity_q[n], data_q[8*n+:8]} <= memory[reading+place_t'(n)];
      always @(posedge CLKBWRCLK)
        if (ENBWREN)
          for (int n = 0; n < Wide; n++)
            if (WEBWE[n]) memory[writing+place_t'(n)] <= {parity[n], data[8*n+:8]};
      assign {DOBDO, DOADO} = data_q;
      assign {DOPBDOP, DOPADOP} = parity_q;
    end else begin : g_narrow
      wire place_t reading = place_t'(ADDRBWRADDR >> 3) & ~place_t'(Narrow - 1);
      wire place_t writing = place_t'(ADDRARDADDR >> 3) & ~place_t'(Narrow - 1);
      reg [8*Narrow-1:0] data_q;
      reg [Narrow-1:0] parity_q;
      always @(posedge CLKBWRCLK)
        if (ENBWREN)
          for (int n = 0; n < Narrow; n++) {parity_q[n], data_q[8*n+:8]} <= memory[reading+place_t'(n)];
      always @(posedge CLKARDCLK)
        if (ENARDEN)
          for (int n = 0; n < Narrow; n++)
            if (WEA[n]) memory[writing+place_t'(n)] <= {DIPADIP[n], DIADI[8*n+:8]};
      assign DOBDO = data_q;
      assign DOPBDOP = parity_q;
    end
  endgenerate

